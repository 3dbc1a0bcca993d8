//! The names that this reader knows.

pub(super) const ANISOTROPY: &str = "KHR_materials_anisotropy";
pub(super) const CLEARCOAT: &str = "KHR_materials_clearcoat";
pub(super) const DISPERSION: &str = "KHR_materials_dispersion";
pub(super) const EMISSIVE_STRENGTH: &str = "KHR_materials_emissive_strength";
pub(super) const IOR: &str = "KHR_materials_ior";
pub(super) const IRIDESCENCE: &str = "KHR_materials_iridescence";
pub(super) const SHEEN: &str = "KHR_materials_sheen";
pub(super) const SPECULAR: &str = "KHR_materials_specular";
pub(super) const SPECULAR_GLOSSINESS: &str = "KHR_materials_pbrSpecularGlossiness";
pub(super) const TRANSMISSION: &str = "KHR_materials_transmission";
pub(super) const UNLIT: &str = "KHR_materials_unlit";
/// It gives a primitive several materials to choose from, and no material anything.
pub(super) const VARIANTS: &str = "KHR_materials_variants";
pub(super) const VOLUME: &str = "KHR_materials_volume";

/// The extensions of materials that are known.
pub(super) const KNOWN: [&str; 12] = [
    ANISOTROPY,
    CLEARCOAT,
    DISPERSION,
    EMISSIVE_STRENGTH,
    IOR,
    IRIDESCENCE,
    SHEEN,
    SPECULAR,
    SPECULAR_GLOSSINESS,
    TRANSMISSION,
    UNLIT,
    VOLUME,
];

/// Names in a material and its parts.
pub(super) const MATERIAL_NAMES: [&str; 10] = [
    "name",
    "extensions",
    "pbrMetallicRoughness",
    "normalTexture",
    "occlusionTexture",
    "emissiveTexture",
    "emissiveFactor",
    "alphaMode",
    "alphaCutoff",
    "doubleSided",
];
pub(super) const METALLIC_ROUGHNESS_NAMES: [&str; 6] = [
    "baseColorFactor",
    "baseColorTexture",
    "metallicFactor",
    "roughnessFactor",
    "metallicRoughnessTexture",
    "extensions",
];
pub(super) const SPECULAR_GLOSSINESS_NAMES: [&str; 6] = [
    "diffuseFactor",
    "diffuseTexture",
    "specularFactor",
    "glossinessFactor",
    "specularGlossinessTexture",
    "extensions",
];
pub(super) const TEXTURE_NAMES: [&str; 5] = ["index", "texCoord", "scale", "strength", "extensions"];
