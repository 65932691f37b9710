//! Classes as a picture.

use super::class::Class;
use crate::image::Image;
use crate::image::legend::{Entry, Legend};
use crate::report::text::thousands;

/// A map of classes, with a legend of those that occur, under a title. Only Latin-1 can be drawn.
#[must_use]
pub fn map(title: &str, size: [u32; 2], classes: &[Class]) -> Image {
    let count = |class: Class| classes.iter().filter(|&&other| other == class).count() as u64;
    let entries: Vec<Entry> = Class::ALL
        .into_iter()
        .map(|class| (class, count(class)))
        .filter(|&(class, count)| count > 0 || class == Class::Equal)
        .map(|(class, count)| Entry {
            color: class.color(),
            text: format!("{}: {} ({})", class.name(), thousands(count), class.meaning()),
        })
        .collect();
    let colors: Vec<[u8; 3]> = classes.iter().map(|class| class.color()).collect();
    Legend { title, size, colors: &colors, entries: &entries }.draw()
}
