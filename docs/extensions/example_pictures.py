"""Pictures of the gallery: the name `figure` of each example, whatever drew it."""

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst


def scrape(_block, variables: dict, settings: dict) -> str:
    """Save the figure that an example has drawn, and return its place in the page."""
    figure = variables["example_globals"].pop("figure", None)
    if not isinstance(figure, Figure):
        return ""
    path = next(variables["image_path_iterator"])
    figure.savefig(path, dpi=110)
    return figure_rst([path], settings["src_dir"])
