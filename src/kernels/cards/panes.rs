//! Panes of one window as one card.
//!
//! Two cards become one if a single rectangle covers the pixels of both, holds each of them and has the same axes. The
//! bars between them stay in its texture.

use glam::{DMat3, DVec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::card_matrix::{centre, corners, point, reach, sizes};
use super::footprint::{Footprint, MOST_SAMPLES, RemovedRadiance};
use super::shape_fit::{FittedShape, Shape, fit};

/// Largest ratio of the luminance of two panes.
const LUMINANCE_RATIO: f64 = 2.0;
/// Largest angle between panes, in radians: 4 degrees.
const LARGEST_GAP: f64 = 0.07;
/// Largest gap relative to the longest side of the smaller pane.
const RELATIVE_GAP: f64 = 0.5;
/// Least overlap of the common rectangle.
const LEAST_OVERLAP: f64 = 0.7;
/// Largest angle between the axes of a pane and its window, in radians: 3 degrees.
const LARGEST_TURN: f64 = 0.052;

/// Lights of a card, and its shape, if there is one.
pub type Group = (Vec<u32>, Option<FittedShape>);

/// Cards with panes merged; in the order of their first lights.
pub fn merge(removed: &RemovedRadiance<'_>, members: &[Vec<u32>], mut groups: Vec<Group>) -> Vec<Group> {
    let step = removed.pixels.step();
    let mut tried: FxHashMap<(Vec<u32>, Vec<u32>), Option<Group>> = FxHashMap::default();
    loop {
        crate::interrupt::check();
        let pairs = near_pairs(&groups);
        let key = |&(first, second): &(usize, usize)| (groups[first].0.clone(), groups[second].0.clone());
        let new: Vec<_> = pairs.iter().copied().filter(|pair| !tried.contains_key(&key(pair))).collect();
        let common = |&(first, second): &(usize, usize)| {
            common(removed, members, &groups[first], &groups[second], step)
        };
        let found: Vec<Option<Group>> = new.par_iter().map(common).collect();
        tried.extend(new.iter().map(key).zip(found));
        let window = pairs.iter().find_map(|pair| Some((*pair, tried[&key(pair)].clone()?)));
        let Some(((first, second), window)) = window else { return groups };
        groups[first] = window;
        groups.remove(second);
    }
}

/// Pairs of cards that may be panes of one window, in order.
fn near_pairs(groups: &[Group]) -> Vec<(usize, usize)> {
    let all =
        (0..groups.len()).flat_map(|first| (first + 1..groups.len()).map(move |second| (first, second)));
    all.filter(|&(first, second)| are_near(groups[first].1.as_ref(), groups[second].1.as_ref())).collect()
}

/// True for two rectangles of similar luminance with a small gap between them.
fn are_near(first: Option<&FittedShape>, second: Option<&FittedShape>) -> bool {
    let (Some(first), Some(second)) = (first, second) else { return false };
    let is_box = |fit: &FittedShape| matches!(fit.shape, Shape::Rectangle | Shape::Tube);
    let ratio = first.inner / second.inner;
    if !is_box(first) || !is_box(second) || !(1.0 / LUMINANCE_RATIO..=LUMINANCE_RATIO).contains(&ratio) {
        return false;
    }
    let longest = |fit: &FittedShape| sizes(&fit.matrix).into_iter().fold(0.0, f64::max);
    let most = LARGEST_GAP.min(RELATIVE_GAP * longest(first).min(longest(second)));
    gap(&first.matrix, &second.matrix) < most
}

/// Least angle between points on the edges of two cards.
fn gap(first: &DMat3, second: &DMat3) -> f64 {
    let apart = centre(first).angle_between(centre(second));
    if apart > reach(first) + reach(second) + LARGEST_GAP {
        return f64::INFINITY;
    }
    let (ours, theirs) = (edge_points(first), edge_points(second));
    let angles = ours.iter().flat_map(|p| theirs.iter().map(move |q| p.angle_between(*q)));
    angles.fold(f64::INFINITY, f64::min)
}

/// Directions of eight points on each edge of a card.
fn edge_points(matrix: &DMat3) -> Vec<DVec3> {
    let at = |i: i32| f64::from(i) / 8.0;
    let edge = |i: i32| [[at(i), 0.0], [at(i), 1.0], [0.0, at(i)], [1.0, at(i)]];
    (0..=8).flat_map(edge).map(|place| point(matrix, place.into()).normalize()).collect()
}

/// Card of two groups, if one rectangle describes both.
fn common(
    removed: &RemovedRadiance<'_>,
    members: &[Vec<u32>],
    first: &Group,
    second: &Group,
    step: f64,
) -> Option<Group> {
    let lights = [first.0.as_slice(), second.0.as_slice()].concat();
    if !are_parallel(first, second) {
        return None;
    }
    let pixels: Vec<u32> =
        lights.iter().flat_map(|&light| members[light as usize - 1].iter().copied()).collect();
    let footprint = Footprint::new(removed, &lights, &pixels, MOST_SAMPLES)?;
    let joint = fit(&footprint)?;
    let is_box = matches!(joint.shape, Shape::Rectangle | Shape::Tube) && joint.overlap >= LEAST_OVERLAP;
    let holds = |part: &Group| part.1.as_ref().is_some_and(|part| is_pane(&part.matrix, &joint.matrix, step));
    if !is_box || !holds(first) || !holds(second) {
        return None;
    }
    Some((lights, Some(joint)))
}

/// True if the axes of two cards are the same within twice the largest turn.
fn are_parallel(first: &Group, second: &Group) -> bool {
    let (Some(first), Some(second)) = (&first.1, &second.1) else { return false };
    turn(&first.matrix, &second.matrix.inverse(), &second.matrix) < 2.0 * LARGEST_TURN
}

/// True if a card lies in another one, within 2 pixels, and has its axes.
fn is_pane(pane: &DMat3, window: &DMat3, step: f64) -> bool {
    let inverse = window.inverse();
    let margin = sizes(window).map(|size| 2.0 * step / size);
    let is_inside = |corner: DVec3| {
        let p = inverse * corner;
        let place = p.truncate() / p.z;
        let holds = |at: f64, margin: f64| (-margin..=1.0 + margin).contains(&at);
        p.z > 0.0 && holds(place.x, margin[0]) && holds(place.y, margin[1])
    };
    corners(pane).into_iter().all(is_inside) && turn(pane, &inverse, window) < LARGEST_TURN
}

/// Least angle between the middle line of a pane and the lines of its window there.
fn turn(pane: &DMat3, inverse: &DMat3, window: &DMat3) -> f64 {
    let at = |matrix: &DMat3, a: f64, b: f64| point(matrix, [a, b].into()).normalize();
    let [along, across] = sizes(pane);
    let ends = if along > across {
        [at(pane, 0.0, 0.5), at(pane, 1.0, 0.5)]
    } else {
        [at(pane, 0.5, 0.0), at(pane, 0.5, 1.0)]
    };
    let places = ends.map(|end| {
        let p = *inverse * end;
        p.truncate() / p.z
    });
    let [width, height] = sizes(window);
    let step = (places[1] - places[0]) * glam::DVec2::new(width, height);
    step.abs().min_element().atan2(step.abs().max_element())
}
