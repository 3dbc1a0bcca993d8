//! A parameter that is grey or linear RGB.
//!
//! Integrands carry three channels in a [`DVec3`] and grey values fill all of them: the arithmetic is the same, and
//! [`Channels`] remembers how many of the three a table has to keep.

use crate::parameter::{Legal, ParameterError};
use glam::DVec3;

/// How many channels of a value are independent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channels {
    /// One value for all wavelengths.
    Grey,
    /// The albedos of a lobe under Schlick's Fresnel term with r0 = 0 and with r0 = 1: that of any other is their mix by r0.
    Pair,
    /// Linear red, green and blue.
    Rgb,
}

impl Channels {
    /// 1, 2 or 3.
    pub fn count(self) -> usize {
        match self {
            Channels::Grey => 1,
            Channels::Pair => 2,
            Channels::Rgb => 3,
        }
    }

    /// The independent channels of `value`.
    pub fn of(self, value: DVec3) -> Vec<f64> {
        value.to_array()[..self.count()].to_vec()
    }
}

/// A grey or linear RGB parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spectrum {
    value: DVec3,
    channels: Channels,
}

impl Spectrum {
    /// The same value in every channel.
    pub const fn grey(value: f64) -> Self {
        Self {
            value: DVec3::splat(value),
            channels: Channels::Grey,
        }
    }

    /// Linear red, green and blue. Three equal values are grey, so that they cost one channel.
    pub fn rgb(rgb: [f64; 3]) -> Self {
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return Self::grey(rgb[0]);
        }
        Self {
            value: DVec3::from_array(rgb),
            channels: Channels::Rgb,
        }
    }

    /// The three channels; equal when grey.
    pub fn value(&self) -> DVec3 {
        self.value
    }

    /// Number of independent channels.
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// The spectrum itself when every channel is legal.
    ///
    /// # Errors
    /// [`ParameterError`] for the first channel outside `legal`.
    pub fn check(self, legal: Legal) -> Result<Self, ParameterError> {
        for value in self.value.to_array() {
            legal.check(value)?;
        }
        Ok(self)
    }
}
