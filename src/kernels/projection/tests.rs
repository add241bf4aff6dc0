//! Every layout: sums of solid angles, round trips, and integrals of the direction.

#![allow(clippy::unwrap_used)]

use std::f64::consts::PI;

use approx::assert_relative_eq;
use glam::{DVec2, DVec3};
use proptest::prelude::*;

use super::places::nodes;
use super::*;

fn azimuthal(size: [usize; 2], mapping: AzimuthalMapping, reach: f64) -> AzimuthalCircle {
    let centre = DVec2::new(size[1] as f64, size[0] as f64) * 0.5;
    AzimuthalCircle::new(size, mapping, reach, (centre, centre.min_element()))
}

/// Layouts of the whole sphere, by name.
fn whole() -> Vec<(&'static str, Box<dyn SphereProjection>)> {
    vec![
        ("map", Box::new(Equirectangular::new([16, 32]))),
        ("odd map", Box::new(Equirectangular::new([9, 18]))),
        ("cube", Box::new(Cube::new(16, false, 1.0))),
        ("odd cube", Box::new(Cube::new(7, false, 1.0))),
        ("border cube", Box::new(Cube::new(9, true, 1.0))),
        ("octahedral", Box::new(Octahedral::new(16))),
        ("equal area", Box::new(EqualArea::new(16))),
        ("odd equal area", Box::new(EqualArea::new(9))),
        ("angular map", Box::new(azimuthal([32, 32], AzimuthalMapping::Equidistant, PI))),
        ("odd angular map", Box::new(azimuthal([33, 33], AzimuthalMapping::Equidistant, PI))),
        ("wide angular map", Box::new(azimuthal([20, 33], AzimuthalMapping::Equidistant, PI))),
        ("mirror ball", Box::new(azimuthal([32, 32], AzimuthalMapping::Equisolid, PI))),
    ]
}

/// Layouts of a part of the sphere, by name, with the solid angle of the part.
fn parts() -> Vec<(&'static str, Box<dyn SphereProjection>, f64)> {
    let half = 2.0 * PI;
    // 8 rows above and below the horizon of a cylinder with the radius 64 / 2 pi.
    let tangent: f64 = 8.0 / (64.0 / (2.0 * PI));
    let ring = 4.0 * PI * tangent / (1.0 + tangent * tangent).sqrt();
    let photograph = 4.0 * 0.75_f64.atan2((1.0 + 1.0 + 0.75 * 0.75_f64).sqrt());
    vec![
        ("crop over the seam", Box::new(Equirectangular::crop([8, 16], [16, 32], [0, 24])), half / 2.0),
        ("cylinder", Box::new(Cylinder::new([16, 64], 2.0 * PI, 8.0)), ring),
        ("equisolid", Box::new(azimuthal([16, 16], AzimuthalMapping::Equisolid, PI / 2.0)), half),
        ("equidistant", Box::new(azimuthal([17, 16], AzimuthalMapping::Equidistant, PI / 2.0)), half),
        ("stereographic", Box::new(azimuthal([16, 16], AzimuthalMapping::Stereographic, PI / 2.0)), half),
        ("orthographic", Box::new(azimuthal([16, 16], AzimuthalMapping::Orthographic, PI / 2.0)), half),
        ("photograph", Box::new(Planar::new([24, 32], PI / 2.0)), photograph),
    ]
}

fn all() -> Vec<(&'static str, Box<dyn SphereProjection>)> {
    whole().into_iter().chain(parts().into_iter().map(|(name, layout, _)| (name, layout))).collect()
}

fn pixels(layout: &dyn SphereProjection) -> std::ops::Range<usize> {
    0..layout.size()[0] * layout.size()[1]
}

#[test]
fn solid_angles_sum_to_what_the_picture_shows() {
    let whole = whole().into_iter().map(|(name, layout)| (name, layout, 4.0 * PI));
    for (name, layout, expected) in whole.chain(parts()) {
        let sum: f64 = pixels(&*layout).map(|pixel| layout.solid_angle(pixel)).sum();
        assert!((sum / expected - 1.0).abs() < 1e-12, "{name}: {sum} {expected}");
    }
}

#[test]
fn a_solid_angle_is_the_integral_of_the_density() {
    for (name, layout) in all() {
        let width = layout.size()[1];
        for pixel in pixels(&*layout) {
            let (row, column) = ((pixel / width) as f64, (pixel % width) as f64);
            let places = (0..4096)
                .map(|i| (column + (f64::from(i % 64) + 0.5) / 64.0, row + (f64::from(i / 64) + 0.5) / 64.0));
            let inside = places.filter(|&(x, y)| layout.direction(x, y).is_some());
            let sum: f64 = inside.map(|(x, y)| layout.density(x, y) / 4096.0).sum();
            // Pixels on the rim are cut by the circle between places.
            let is_cut = nodes(&*layout, pixel).len() != 16;
            // The density of an orthographic picture is infinite on the rim.
            let relative = if name == "orthographic" { 3e-2 } else { 2e-3 };
            let tolerance = if is_cut { 3e-4 * 4.0 * PI } else { relative * layout.solid_angle(pixel) };
            assert!(
                (sum - layout.solid_angle(pixel)).abs() < tolerance,
                "{name} {pixel}: {sum} {}",
                layout.solid_angle(pixel)
            );
        }
    }
}

#[test]
fn the_moments_of_all_pixels_of_the_sphere_sum_to_zero() {
    for (name, layout) in whole() {
        let is_circle = name.contains("angular") || name.contains("ball");
        let sum: DVec3 =
            pixels(&*layout).filter(|&i| layout.solid_angle(i) > 0.0).map(|i| layout.moment(i)).sum();
        // The central pixel of an odd square has a kink at the pole.
        let tolerance = if name == "odd equal area" { 1e-2 } else { 1e-4 };
        assert!(is_circle || sum.length() < tolerance, "{name}: {sum}");
    }
}

#[test]
fn axes_edges_and_corners_have_a_place_that_leads_back() {
    for (name, layout) in whole() {
        for code in 0..27 {
            let exact =
                DVec3::new(f64::from(code % 3 - 1), f64::from(code / 3 % 3 - 1), f64::from(code / 9 - 1));
            if code == 13 {
                continue;
            }
            for nudge in [DVec3::ZERO, DVec3::new(1e-9, 0.0, 0.0), DVec3::new(0.0, -1e-9, 1e-9)] {
                let direction = (exact + nudge).normalize();
                let place = layout.place(direction).unwrap();
                let back = layout.direction(place.x, place.y).unwrap();
                // The radius of a mirror ball is flat at its rim: half of the digits are lost.
                let tolerance = if name == "mirror ball" { 4e-8 } else { 1e-12 };
                assert!((back - direction).length() < tolerance, "{name} {direction}: {back}");
                let pixel = layout.pixel((3.0 * direction).to_array());
                assert!((pixel as usize) < pixels(&*layout).end, "{name}");
            }
        }
    }
}

#[test]
fn named_places_look_where_the_convention_says() {
    let at = |layout: &dyn SphereProjection, x: f64, y: f64| layout.direction(x, y).unwrap().to_array();
    let cube = Cube::new(8, false, 1.0);
    for (face, expected) in
        [DVec3::Z, DVec3::NEG_X, DVec3::NEG_Z, DVec3::X, DVec3::Y, DVec3::NEG_Y].iter().enumerate()
    {
        assert_relative_eq!(at(&cube, 4.0, 8.0 * face as f64 + 4.0)[..], expected.to_array()[..]);
    }
    // The lower edge of up touches the upper edge of front; the upper edge of down its lower one.
    assert_relative_eq!(at(&cube, 4.0, 39.99)[..], at(&cube, 4.0, 0.0)[..], epsilon = 3e-3);
    assert_relative_eq!(at(&cube, 4.0, 40.0)[..], at(&cube, 4.0, 7.99)[..], epsilon = 3e-3);
    let octahedral = Octahedral::new(8);
    let equal_area = EqualArea::new(8);
    for square in [&octahedral as &dyn SphereProjection, &equal_area] {
        assert_relative_eq!(at(square, 4.0, 4.0)[..], [0.0, 0.0, 1.0][..]);
        assert_relative_eq!(at(square, 8.0, 4.0)[..], [-1.0, 0.0, 0.0][..], epsilon = 1e-15);
        assert_relative_eq!(at(square, 4.0, 8.0)[..], [0.0, -1.0, 0.0][..], epsilon = 1e-15);
    }
    let angular = azimuthal([8, 8], AzimuthalMapping::Equidistant, PI);
    assert_relative_eq!(at(&angular, 6.0, 4.0)[..], [-1.0, 0.0, 0.0][..], epsilon = 1e-15);
    assert_relative_eq!(
        at(&Planar::new([4, 4], PI / 2.0), 4.0, 2.0)[..],
        [-0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt()][..]
    );
}

#[test]
fn neighbours_beyond_an_edge_are_near() {
    for (name, layout) in whole() {
        let width = layout.size()[1];
        let is_circle = name.contains("angular") || name.contains("ball");
        if is_circle || name == "border cube" {
            continue;
        }
        for pixel in pixels(&*layout) {
            let centre = |pixel: usize| layout.moment(pixel).normalize();
            let own = centre(pixel);
            for step in [[0, 1], [1, 0], [0, -1], [-1, 0]] {
                let other = layout.neighbour(pixel, step).unwrap();
                let across = own.distance(centre(other));
                let limit = 3.0 * layout.mean_solid_angle().sqrt();
                assert!(across < limit, "{name} {pixel} of rows of {width}: {other} is {across} away");
            }
        }
    }
}

proptest! {
    #[test]
    fn a_direction_leads_to_a_place_and_back(x in -1.0..1.0_f64, y in -1.0..1.0_f64, z in -1.0..1.0_f64) {
        let direction = DVec3::new(x, y, z);
        prop_assume!(direction.length() > 0.05);
        let direction = direction.normalize();
        for (name, layout) in all() {
            let Some(place) = layout.place(direction) else { continue };
            let Some(back) = layout.direction(place.x, place.y) else {
                // Outside of the picture, inside the circle.
                continue;
            };
            let tolerance = if name == "mirror ball" || name == "orthographic" { 2e-8 } else { 1e-12 };
            prop_assert!((back - direction).length() < tolerance, "{name}: {direction} {back}");
            let pixel = layout.pixel((2.0 * direction).to_array());
            let [height, width] = layout.size();
            let is_clear = |at: f64| (at - at.round()).abs() > 1e-9;
            if is_clear(place.x) && is_clear(place.y) && place.x < width as f64 && place.y < height as f64 {
                prop_assert_eq!(pixel as usize, place.y as usize * width + place.x as usize, "{}", name);
            }
        }
    }
}
