//! Closed forms, limits and rays.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;
use proptest::prelude::*;

use super::cone::Cone;
use super::convex::{ConvexRegion, cosine_integral};
use super::occlusion::Place;
use super::*;
use crate::kernels::disc::irradiance_share;

fn ball(centre: [f64; 3], radius: f64) -> Solid {
    Solid::Ball(Ball { centre: centre.into(), radius })
}

/// A box with half sides, turned about +y.
fn brick(centre: [f64; 3], half: [f64; 3], turn: f64) -> Solid {
    let corner = |code: usize| {
        let sign = |bit: usize| if code >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let (x, y, z) = (sign(0) * half[0], sign(1) * half[1], sign(2) * half[2]);
        let (sin, cos) = turn.sin_cos();
        DVec3::from(centre) + DVec3::new(cos * x + sin * z, y, cos * z - sin * x)
    };
    let loops =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]].map(Vec::from);
    Solid::Polyhedron(Polyhedron::new((0..8).map(corner).collect(), &loops).expect("a convex polyhedron"))
}

fn cap(axis: DVec3, angle: f64) -> ConvexRegion {
    ConvexRegion::cone(Cone::of_angle(axis, angle))
}

fn sources(directions: &[DVec3], radii: &[f64]) -> Sources {
    Sources::new(directions, radii, true)
}

fn direction_at(elevation: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = elevation.sin_cos();
    DVec3::new(cos * azimuth.sin(), sin, cos * azimuth.cos())
}

/// Evenly spread directions of the sphere, each of the solid angle 4 pi / count.
fn spread(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |index| {
        let y = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
        let azimuth = TAU * (f64::from(index) * 0.618_033_988_749_894_9).fract();
        direction_at(y.asin(), azimuth)
    })
}

/// True if a ray from outside meets a ball, or the convex hull of the corners of a brick: by its own equations.
fn is_hit(solid: &Solid, point: DVec3, direction: DVec3) -> bool {
    match solid {
        Solid::Ball(ball) => {
            let away = ball.centre - point;
            let along = away.dot(direction);
            along > 0.0 && away.length_squared() - along * along < ball.radius * ball.radius
        }
        Solid::Polyhedron(polyhedron) => polyhedron.is_hit(point, direction),
    }
}

#[test]
fn one_cone_has_the_cosine_times_its_solid_angle_on_the_plane() {
    for angle in [1e-4, 0.3, 1.2, FRAC_PI_2] {
        let normal = direction_at(0.4, 1.0);
        let whole = cosine_integral(DVec3::Y, &[&cap(normal, angle)]);
        let expected = PI * angle.sin().powi(2) * normal.y;
        assert!((whole / expected - 1.0).abs() < 1e-12, "{angle}");
    }
}

#[test]
fn a_cone_over_the_horizon_is_the_disc_of_the_fit() {
    for step in 0..400 {
        let angle = 1.57 * f64::from(step % 20 + 1) / 20.0;
        let axis = direction_at(1.5 * (f64::from(step / 20) / 10.0 - 1.0), 0.3);
        let sky = ConvexRegion::cone(Cone::half_space(DVec3::Y));
        let share = cosine_integral(DVec3::Y, &[&cap(axis, angle), &sky]) / (PI * angle.sin().powi(2));
        assert!((share - irradiance_share(axis.y, angle)).abs() < 1e-12, "{angle} {axis}");
    }
}

#[test]
fn a_ball_that_covers_a_disc_exactly_hides_it() {
    for radius in [0.0047_f64, 0.2, 1.3] {
        let light = direction_at(1.0, 0.5);
        for scale in [1.0 - 1e-13, 1.0, 1.0 + 1e-13] {
            let cover = ball((10.0 * light).into(), 10.0 * radius.sin() * scale);
            let place = Place::new(DVec3::ZERO, light, None, std::slice::from_ref(&cover));
            let hidden = place.hidden_disc(&sources(&[light], &[radius]), 0);
            assert!((hidden - 1.0).abs() < 1e-9, "{radius} {scale} {hidden}");
        }
    }
}

#[test]
fn two_solids_in_one_place_hide_what_one_does() {
    let (one, other) = (ball([1.0, 0.6, 0.3], 0.5), brick([1.0, 0.6, 0.3], [0.5; 3], 0.2));
    let lights = sources(&[direction_at(0.5, 1.2), direction_at(0.4, 1.3)], &[0.6, 0.01]);
    for solids in [vec![one.clone(), one], vec![other.clone(), other]] {
        let both = Place::new(DVec3::ZERO, DVec3::Y, None, &solids);
        let alone = Place::new(DVec3::ZERO, DVec3::Y, None, &solids[..1]);
        assert!((both.hidden_ambient(&lights) - alone.hidden_ambient(&lights)).abs() < 1e-9);
        for light in 0..2 {
            let (two, one) = (both.hidden_disc(&lights, light), alone.hidden_disc(&lights, light));
            assert!((two - one).abs() < 1e-9, "{two} {one}");
        }
    }
}

#[test]
fn a_box_of_many_flat_faces_is_the_box() {
    // Each side as two triangles: points in the plane of a side see it edge on.
    let Solid::Polyhedron(whole) = brick([0.0, 0.5, 0.0], [0.5; 3], 0.0) else { unreachable!() };
    let corners = whole.corners().to_vec();
    let quads = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let halves = quads.iter().flat_map(|q| [vec![q[0], q[1], q[2]], vec![q[0], q[2], q[3]]]);
    let split = Polyhedron::new(corners, &halves.collect::<Vec<_>>()).expect("a convex polyhedron");
    let lights = sources(&[direction_at(0.5, 1.2)], &[0.5]);
    for point in [[2.0, 0.0, 0.5], [0.5, 0.0, 2.0], [0.5, 0.2, 3.0], [1.0, 0.0, 1.0], [0.2, 0.0, 0.1]] {
        let shares = [Solid::Polyhedron(whole.clone()), Solid::Polyhedron(split.clone())].map(|solid| {
            let place = Place::new(point.into(), DVec3::Y, None, std::slice::from_ref(&solid));
            [place.hidden_ambient(&lights), place.hidden_disc(&lights, 0)]
        });
        for (a, b) in shares[0].iter().zip(shares[1]) {
            assert!((a - b).abs() < 1e-9, "{point:?} {a} {b}");
        }
    }
}

#[test]
fn what_is_no_convex_polyhedron_is_refused() {
    let corners: Vec<DVec3> = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].to_vec();
    let faces = [vec![0, 1, 2], vec![0, 1, 3], vec![0, 2, 3], vec![1, 2, 3]];
    assert!(Polyhedron::new(corners.clone(), &faces).is_ok());
    assert!(Polyhedron::new(corners.clone(), &faces[..3]).is_err());
    assert!(Polyhedron::new(corners.clone(), &[vec![0, 1, 9]]).is_err());
    let dented = [corners, vec![DVec3::splat(0.1)]].concat();
    let open = [vec![0, 1, 2], vec![0, 1, 3], vec![0, 2, 3], vec![1, 2, 4], vec![2, 3, 4], vec![3, 1, 4]];
    assert!(Polyhedron::new(dented, &open).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn no_number_is_not_finite(
        x in -1.0..1.0_f64, y in 0.0..1.0_f64, z in -1.0..1.0_f64, elevation in -1.57..1.57_f64, radius in 0.0..1.57_f64,
    ) {
        let solids = [ball([0.0, 0.5, 0.0], 0.5), brick([0.5, 0.5, 0.0], [0.5; 3], 0.0)];
        let lights = sources(&[direction_at(elevation, 0.4)], &[radius]);
        // Also inside of the solids and on their planes.
        for point in [DVec3::new(x, y, z), DVec3::new(x, 0.0, z), DVec3::new(0.0, y, 0.5)] {
            let place = Place::new(point, DVec3::Y, None, &solids);
            let (ambient, disc) = (place.hidden_ambient(&lights), place.hidden_disc(&lights, 0));
            prop_assert!((0.0..=1.0).contains(&ambient) && (0.0..=1.0).contains(&disc), "{ambient} {disc}");
        }
    }
}

#[test]
fn silhouettes_contain_the_rays_that_hit() {
    let solids = [ball([0.3, 0.5, 0.2], 0.5), brick([-0.5, 0.4, 0.1], [0.4, 0.4, 0.3], 0.3)];
    for solid in &solids {
        for point in [DVec3::new(1.0, 0.2, 1.5), DVec3::new(-2.0, 0.0, 0.3), DVec3::new(0.0, 4.0, 0.0)] {
            let silhouette = solid.silhouette(point);
            for direction in spread(20_000) {
                assert_eq!(silhouette.contains(direction), is_hit(solid, point, direction));
            }
        }
    }
}

#[test]
fn a_white_furnace_gives_pi_everywhere() {
    // A floor and solids of albedo 1 under a sky of radiance 1 would receive pi; the model must not exceed it by much.
    let solids = [ball([0.0, 0.5, 0.0], 0.5), brick([1.2, 0.4, 0.0], [0.4; 3], 0.3)];
    let surroundings = Surroundings {
        ambient: DVec3::ONE,
        irradiance: Vec::new(),
        albedo: vec![DVec3::ONE; 2],
        floor_albedo: DVec3::ONE,
    };
    let points = vec![DVec3::new(3.0, 0.0, 1.0), DVec3::new(0.0, 1.0, 0.0), DVec3::new(1.2, 0.8, 0.0)];
    let receivers = Receivers { points, normals: vec![DVec3::Y; 3], own: vec![None, Some(0), Some(1)] };
    let values = received_irradiance(&receivers, &sources(&[], &[]), &solids, &surroundings);
    for value in &values {
        assert!((value / PI - 1.0).abs() < 0.05, "{value}");
    }
}

#[test]
fn white_surfaces_in_contact_reflect_finite_light() {
    let solids = [ball([0.0, 0.5, 0.0], 0.5)];
    let surroundings = Surroundings {
        ambient: DVec3::ONE,
        irradiance: vec![DVec3::ONE],
        albedo: vec![DVec3::ONE],
        floor_albedo: DVec3::ONE,
    };
    let points = vec![DVec3::ZERO, DVec3::new(1e-9, 0.0, 0.0), DVec3::new(1e-3, 0.0, 0.0)];
    let receivers = Receivers { points, normals: vec![DVec3::Y; 3], own: vec![None; 3] };
    let sources = sources(&[DVec3::Y], &[0.1]);
    let values = received_irradiance(&receivers, &sources, &solids, &surroundings);
    assert!(values.iter().all(|&value| (0.0..2.0 * PI).contains(&value)), "{values}");
}
