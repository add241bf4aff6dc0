//! Some pixels side by side, channel by channel: eight of them fit into one wide vector.
#![allow(clippy::inline_always, reason = "what is not inlined is compiled for the oldest of processors")]

use std::array;

use crate::kernels::image::luminance_f32;

/// So many channels of some pixels, one after the other.
#[derive(Default)]
pub struct Planes<const CHANNELS: usize> {
    values: Vec<f32>,
    pixels: usize,
}

impl<const CHANNELS: usize> Planes<CHANNELS> {
    /// Make room for so many pixels, which are to be filled.
    pub fn start(&mut self, pixels: usize) {
        self.pixels = pixels;
        self.values.resize(CHANNELS * pixels, 0.0);
    }

    /// All channels, one after the other.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// All channels, to be filled.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// Each channel.
    #[inline(always)]
    pub fn channels(&self) -> [&[f32]; CHANNELS] {
        let mut channels = [[].as_slice(); CHANNELS];
        for (channel, values) in channels.iter_mut().zip(self.values.chunks_exact(self.pixels)) {
            *channel = values;
        }
        channels
    }

    /// Each channel, to be filled.
    #[inline(always)]
    pub fn channels_mut(&mut self) -> [&mut [f32]; CHANNELS] {
        let mut channels = self.values.chunks_exact_mut(self.pixels);
        array::from_fn(|_| channels.next().expect("there are as many as channels"))
    }
}

impl Planes<3> {
    /// Fill the channels from pixels.
    #[inline(always)]
    pub fn read(&mut self, pixels: &[[f32; 3]]) {
        let [red, green, blue] = self.channels_mut();
        for (((pixel, red), green), blue) in pixels.iter().zip(red).zip(green).zip(blue) {
            [*red, *green, *blue] = *pixel;
        }
    }

    /// Fill pixels from the channels.
    #[inline(always)]
    pub fn write(&self, pixels: &mut [[f32; 3]]) {
        let [red, green, blue] = self.channels();
        for (((pixel, &red), &green), &blue) in pixels.iter_mut().zip(red).zip(green).zip(blue) {
            *pixel = [red, green, blue];
        }
    }

    /// The luminance of each pixel.
    #[inline(always)]
    pub fn luminance(&self, luminance: &mut [f32]) {
        let [red, green, blue] = self.channels();
        for (((luminance, &red), &green), &blue) in luminance.iter_mut().zip(red).zip(green).zip(blue) {
            *luminance = luminance_f32([red, green, blue]);
        }
    }

    /// The luminance of each pixel without that of others.
    #[inline(always)]
    pub fn luminance_without<const MORE: usize>(&self, others: &Planes<MORE>, luminance: &mut [f32]) {
        let [red, green, blue] = self.channels();
        let others = others.channels();
        let these = luminance.iter_mut().zip(red).zip(green).zip(blue);
        let both = these.zip(others[0]).zip(others[1]).zip(others[2]);
        for ((((((luminance, &red), &green), &blue), &other_red), &other_green), &other_blue) in both {
            *luminance = luminance_f32([red - other_red, green - other_green, blue - other_blue]);
        }
    }
}
