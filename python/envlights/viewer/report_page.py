"""Page on a map: pictures, lights, errors and notes, in one file without scripts."""

from __future__ import annotations

import base64
import io
from html import escape

from envlights import plot
from envlights._common import html
from envlights.environment.envmap import EnvMap
from envlights.fitting.error_curve import ErrorCurve
from envlights.rigs.rig import Rig

_STYLE = (
    "body{font:15px/1.5 sans-serif;max-width:60em;margin:2em auto;padding:0 1em}"
    "td,th{padding:0.1em 0.8em;text-align:right}img{max-width:100%}"
)


def report_page(env: EnvMap, rig: Rig, curve: ErrorCurve, title: str) -> str:
    """HTML of a map, its rig and its errors by number of lights."""
    sections = {
        "Map": env._repr_html_(),
        "Lights": rig._repr_html_() + _picture(env, rig),
        "Errors by number of lights": curve._repr_html_(),
        "Report of the fit": html.lines(rig.report.verbose()),
        "Notes": html.lines("\n".join(rig.notes or ("no notes",))),
    }
    body = "".join(f"<h2>{escape(name)}</h2>{content}" for name, content in sections.items())
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{_STYLE}</style>'
    return (
        f'<!DOCTYPE html><html lang="en"><head>{head}</head>'
        f"<body><h1>{escape(title)}</h1>{body}</body></html>\n"
    )


def _picture(env: EnvMap, rig: Rig) -> str:
    """Map with its lights, and the probes under both."""
    content = io.BytesIO()
    plot.picture(env, rig).savefig(content, format="png")
    data = base64.b64encode(content.getvalue()).decode()
    return f'<img alt="the map and its lights" src="data:image/png;base64,{data}">'
