//! What kind of scattering a BxDF describes, and the choice among kinds.

use bitflags::bitflags;

bitflags! {
    /// Sides and sharpness of a BxDF [pbrt 2010, section 8.1].
    ///
    /// Every single BxDF has at least one side and exactly one sharpness; a sum has those of its parts.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub struct Flags: u8 {
        /// wi on the side of wo.
        const REFLECTION = 1;
        /// wi on the other side.
        const TRANSMISSION = 2;
        /// All directions alike, or nearly.
        const DIFFUSE = 4;
        /// A lobe around some direction.
        const GLOSSY = 8;
        /// A single direction: f is a delta distribution, seen by `sample_f` alone.
        const SPECULAR = 16;
    }
}

impl Flags {
    /// Whether everything that these flags describe is wanted: `self & wanted == self` [pbrt 2010, section 8.1].
    pub fn matches(self, wanted: Self) -> bool {
        wanted.contains(self)
    }

    /// The same sharpness on the opposite sides.
    ///
    /// Exchanging both bits, as [pbrt 2010, section 8.1] does with an exclusive or, would leave none of them for a model
    /// that scatters to both sides.
    pub fn mirrored(self) -> Self {
        let mut mirrored = self - (Self::REFLECTION | Self::TRANSMISSION);
        mirrored.set(Self::REFLECTION, self.contains(Self::TRANSMISSION));
        mirrored.set(Self::TRANSMISSION, self.contains(Self::REFLECTION));
        mirrored
    }
}

#[cfg(test)]
mod tests {
    use super::Flags;

    #[test]
    fn a_bxdf_matches_when_all_of_it_is_wanted() {
        let mirror = Flags::REFLECTION | Flags::SPECULAR;
        assert!(mirror.matches(Flags::all()));
        assert!(mirror.matches(Flags::all() - Flags::TRANSMISSION));
        assert!(!mirror.matches(Flags::all() - Flags::SPECULAR));
        let glass = mirror | Flags::TRANSMISSION;
        assert!(!glass.matches(mirror));
    }

    #[test]
    fn a_mirrored_model_scatters_to_the_opposite_sides() {
        let mirror = Flags::REFLECTION | Flags::SPECULAR;
        assert_eq!(mirror.mirrored(), Flags::TRANSMISSION | Flags::SPECULAR);
        let glass = mirror | Flags::TRANSMISSION;
        assert_eq!(glass.mirrored(), glass);
        assert_eq!(Flags::empty().mirrored(), Flags::empty());
    }
}
