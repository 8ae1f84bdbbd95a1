#!/usr/bin/env python3
"""Draws @NAME@ from @NAME@.csv with matplotlib; written by `phalanx report --format matplotlib`.

    python @NAME@.py [FILE]

FILE is @NAME@.pdf beside this script if it is not given; its ending chooses the format. Change what you like: FIGURE says what is
drawn and how, lengths in points unless they say otherwise, places in parts of the figure; the data has a row for every point.
"""

import csv
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.font_manager
import matplotlib.lines
import matplotlib.pyplot as plt

FIGURE = @FIGURE@

FONTS = {
    "times": ["Liberation Serif", "Times New Roman", "STIXGeneral"],
    "helvetica": ["Liberation Sans", "Helvetica", "Arial", "DejaVu Sans"],
}


def use_font(family, size):
    """The first font of the family that there is, for texts and for formulas."""
    known = matplotlib.font_manager.get_font_names()
    font = next(name for name in FONTS[family] if name in known)
    plt.rcParams.update({
        "font.family": font,
        "font.size": size,
        "axes.labelsize": size,
        "axes.titlesize": size,
        "xtick.labelsize": size,
        "ytick.labelsize": size,
        "legend.fontsize": size,
        "mathtext.fontset": "custom",
        "mathtext.rm": font,
        "mathtext.it": f"{font}:italic",
        "mathtext.bf": f"{font}:bold",
        "mathtext.cal": font,
        "axes.unicode_minus": True,
        "lines.scale_dashes": False,
        "pdf.fonttype": 42,
        "svg.fonttype": "path",
    })


def read(path):
    """The points of every line: data[plot, line] = (x, y)."""
    data = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            x, y = data.setdefault((int(row["plot"]), int(row["line"])), ([], []))
            x.append(float(row["x"]))
            y.append(float(row["y"]))
    return data


def look(style):
    """What matplotlib calls our styles."""
    return {
        "color": style["colour"],
        "linestyle": (0, style["dashes"]) if style["dashes"] else "solid",
        "linewidth": FIGURE["line_width"],
        "marker": style["marker"],
        "markersize": FIGURE["marker_size"],
        "markerfacecolor": "white",
        "markeredgewidth": 0.7,
    }


def draw_plot(axes, plot, lines):
    for limit in plot["limits"]:
        axes.axhline(limit, color="#444444", linewidth=0.7, dashes=[3.5, 2.0], zorder=1)
    for style, (x, y) in zip(plot["lines"], lines):
        axes.plot(x, y, **look(style), markevery=style["marks"], zorder=2)
        if style["ends"]:
            end = {"color": style["colour"], "marker": "o", "markersize": 1.4 * FIGURE["marker_size"], "zorder": 3}
            axes.plot(x[0], y[0], **end, markerfacecolor="white", markeredgewidth=0.8)
            axes.plot(x[-1], y[-1], **end)
    axes.set_yscale("log" if plot["logarithmic"] else "linear")
    for axis, limits in [("x", plot["x_range"]), ("y", plot["y_range"])]:
        ticks = plot[f"{axis}_ticks"]
        values, names = [value for value, _ in ticks], [name for _, name in ticks]
        getattr(axes, f"set_{axis}ticks")(values, names)
        getattr(axes, f"set_{axis}ticks")(plot.get(f"{axis}_minor_ticks", []), [], minor=True)
        getattr(axes, f"set_{axis}lim")(*limits)
    axes.tick_params(which="both", direction="in", width=0.6)
    axes.grid(which="major", color="#dddddd", linewidth=0.4)
    axes.set_axisbelow(True)
    axes.tick_params(labelbottom=plot["is_named"])
    axes.set_xlabel(plot["x_label"] if plot["is_named"] else "")
    axes.set_ylabel(plot["y_label"])
    axes.set_title(plot["title"], pad=3)
    if plot["factor"]:
        axes.text(0, 1.03, plot["factor"], transform=axes.transAxes)
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)


def sample(entry):
    """The line of an entry of the legend."""
    if entry["sample"] == "curve":
        return matplotlib.lines.Line2D([], [], **look(entry))
    face = "white" if entry["sample"] == "start" else "black"
    size = 1.4 * FIGURE["marker_size"]
    return matplotlib.lines.Line2D([], [], color="black", linestyle="", marker="o", markersize=size, markerfacecolor=face)


def main():
    script = pathlib.Path(__file__)
    use_font(FIGURE["font"], FIGURE["font_size"])
    data = read(script.with_suffix(".csv"))
    figure = plt.figure(figsize=(FIGURE["width_inches"], FIGURE["height_inches"]))
    for number, plot in enumerate(FIGURE["plots"]):
        lines = [data.get((number, line), ([], [])) for line in range(len(plot["lines"]))]
        draw_plot(figure.add_axes(plot["place"]), plot, lines)
    if FIGURE["legend"]:
        handles = [sample(entry) for entry in FIGURE["legend"]]
        names = [entry["name"] for entry in FIGURE["legend"]]
        columns = FIGURE["legend_columns"]
        # matplotlib fills columns, we fill rows.
        order = [k for column in range(columns) for k in range(column, len(names), columns)]
        figure.legend([handles[k] for k in order], [names[k] for k in order], ncols=columns, loc="lower center",
                      frameon=False, handlelength=2.6, borderaxespad=0.1, borderpad=0.2, labelspacing=0.3, columnspacing=1.6)
    for text, x, y in FIGURE["note"]:
        figure.text(x, y, text)
    figure.savefig(sys.argv[1] if len(sys.argv) > 1 else script.with_suffix(".pdf"), dpi=600)


if __name__ == "__main__":
    main()
