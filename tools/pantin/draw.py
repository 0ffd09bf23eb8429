#!/usr/bin/python3 -B
"""Draws the results of `pantin chart` (chart.json) and `pantin stability` (map.json) in a folder.

usage: draw.py chart|map FOLDER
"""
import html
import json
import math
import os
import pathlib
import sys

SYSTEM = "/usr/bin/python3"
LEAST = 1e-17  # drawn for 0 on a logarithmic axis

# Colours that everybody tells apart [Okabe & Ito], one for each method everywhere.
STYLES = {
    "auto": ("#D55E00", "^"), "sweep": ("#999999", "x"), "shake2": ("#56B4E9", "P"),
    "procedural": ("#8B5A2B", "1"), "planar": ("#B2182B", "h"), "scene": ("#444444", "p"),
    "lagrangian/euler": ("#E69F00", "v"), "lagrangian/rattle": ("#009E73", "s"),
    "lagrangian/rk4": ("#0072B2", "o"), "lagrangian/implicit": ("#CC79A7", "D"),
    "lagrangian/radau": ("#000000", "*")}
PANELS = [("position_m", "position, m"), ("orientation_rad", "orientation, rad"),
          ("energy_j", "energy, J"), ("joints_m", "joints, m"), ("depth_m", "contact depth, m")]


def style_of(method):
    colour, mark = STYLES.get(method.removesuffix("/tolerance"), ("#666666", "."))
    return {"color": colour, "marker": mark, "ls": ":" if method.endswith("/tolerance") else "-"}


def save(figure, path):
    """Beside its place until it is whole."""
    part = path.with_name(path.name + ".part")
    try:
        figure.savefig(part, format=path.suffix[1:])
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def write(path, text):
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


def stems(scenes):
    """A file name for each scene."""
    seen, names = {}, []
    for scene in scenes:
        stem = pathlib.Path(scene["scene"]).stem
        seen[stem] = seen.get(stem, 0) + 1
        names.append(stem if seen[stem] == 1 else f"{stem}-{seen[stem]}")
    return names


def curves(scene, key):
    """(method, costs, errors, whether each is on the front) of the runs that were completed."""
    found = {}
    for run in scene["runs"]:
        if run["status"] == "ok" and run["cost_ns"] is not None and run.get(key) is not None:
            found.setdefault(run["method"], []).append(run)
    for method, runs in found.items():
        yield (method, [r["cost_ns"] for r in runs],
               [max(LEAST, r[key]) for r in runs], runs)


def draw_peers(axes, scene, size):
    """Other engines: dashed, in greys."""
    peers = {}
    for run in scene.get("peers", []):
        if run["status"] == "ok" and run["cost_ns"] and run["position_m"] is not None:
            peers.setdefault(run["method"], []).append(run)
    for i, (method, runs) in enumerate(peers.items()):
        style = {"color": ("#555555", "#8a8a8a", "#b0b0b0")[i % 3], "marker": "<>dHX8"[i % 6]}
        axes.plot([r["cost_ns"] for r in runs], [max(LEAST, r["position_m"]) for r in runs], ls="--",
                  ms=size, lw=0.9, label=method, **style)
        best = [(r["cost_ns"], max(LEAST, r["position_m"])) for r in runs if r["front"]]
        if best:
            axes.plot(*zip(*best), "o", ms=11, mfc="none", mec=style["color"], mew=0.9, ls="none")


def draw_panel(axes, scene, key, title, large):
    size = 5 if large else 3
    axes.set_title(title, fontsize=9, loc="left")
    shown = [max(errors) for _, _, errors, _ in curves(scene, key)]
    if not shown or max(shown) <= LEAST:
        axes.text(0.5, 0.5, "none" if shown else "no run", ha="center", transform=axes.transAxes, fontsize=8, color="#666666")
        axes.set_xticks([]), axes.set_yticks([])
        return
    for method, costs, errors, runs in curves(scene, key):
        style = style_of(method)
        axes.plot(costs, errors, ms=size, lw=1.1 if large else 0.8, label=method, **style)
        if not large:
            continue
        low = [r["cost_ns"] - r["cost_low_ns"] for r in runs]
        high = [r["cost_high_ns"] - r["cost_ns"] for r in runs]
        axes.errorbar(costs, errors, xerr=[low, high], fmt="none", ecolor=style["color"], lw=0.7)
        best = [(c, e) for c, e, r in zip(costs, errors, runs) if r["front"]]
        if best:
            axes.plot(*zip(*best), "o", ms=11, mfc="none", mec=style["color"], mew=0.9)
    axes.set_xscale("log")
    axes.set_yscale("log")
    if key == "position_m":
        draw_peers(axes, scene, size)
    own = scene["reference"].get(key)
    if own and own > LEAST:
        axes.axhspan(LEAST, own, color="#000000", alpha=0.1, lw=0)
    bottom, top = axes.get_ylim()
    shown = [e for _, _, errors, _ in curves(scene, key) for e in errors]
    if key == "position_m":
        shown += [max(LEAST, r["position_m"]) for r in scene.get("peers", [])
                  if r["status"] == "ok" and r["position_m"] is not None]
    if shown:
        bottom, top = min(shown) / 3, max(shown) * 10
        if own:
            bottom = min(bottom, max(own / 3, LEAST))
    axes.set_ylim(max(bottom, LEAST / 3), top)
    for name, at in (("real time", scene["real_time_ns"]),
                     ("a tenth of a frame", scene["tenth_of_frame_ns"])):
        axes.axvline(at, color="#888888", lw=0.8, ls="--")
        if large:
            axes.annotate(name, (at, axes.get_ylim()[0]), xytext=(-3, 4), fontsize=7,
                          textcoords="offset points", rotation=90, va="bottom", ha="right",
                          color="#666666")
    for run in scene["runs"]:
        if run["status"] not in ("ok", "not_run") and run.get("cost_measured_ns"):
            style = style_of(run["method"])
            axes.plot([run["cost_measured_ns"]], [top / 2], marker="X", ms=6 if large else 4,
                      color=style["color"], mec="#ffffff", mew=0.4, ls="none")
    axes.tick_params(labelsize=7)
    axes.grid(True, which="major", lw=0.3, color="#cccccc")


def words_of(scene):
    """What the pictures cannot show, a line each."""
    r = scene["reference"]
    lines = []
    if r["horizon_s"] <= 0:
        why = "no method agrees with itself" if r["tried"] else "the time was too short for two runs"
        lines.append(f"No reference: {why}; errors are unknown.")
    else:
        step = f", steps of {1e3 * r['step_s']:.3g} ms" if r["step_s"] else ""
        own = (f"its own error, {r['position_m']:.1e} m, is the grey band" if r["position_m"] is not None
               else "its own error is unknown")
        lines.append(f"Reference: {r['method']}{step}; {own}.")
        if not r["whole"]:
            follows = {}
            for run in scene["runs"]:
                if run.get("follows_s") is not None:
                    follows[run["method"]] = max(follows.get(run["method"], 0), run["follows_s"])
            lines.append(f"Refinements agree up to {r['horizon_s']:.3g} s of {scene['duration_s']:.3g} s: "
                         f"errors are those of the first {r['compared_s']:.3g} s. Within a hundredth of "
                         "the motion at best: " +
                         ", ".join(f"{m} {s:.3g} s" for m, s in follows.items()))
    failed = {}
    for run in scene["runs"]:
        if run["status"] not in ("ok",):
            at = (f"{run['tolerance']:.0e}" if run["tolerance"] else f"{1e3 * run['step_s']:.3g} ms")
            failed.setdefault((run["method"], run["status"]), []).append(at)
    for (method, status), at in failed.items():
        lines.append(f"{method}: {status.replace('_', ' ')} at {', '.join(at)}")
    for one in scene["refused"]:
        reason = one["reason"].split(": ", 1)[-1]
        lines.append(f"{one['method']}: refused: {reason}")
    return lines


def clip(text, most=150):
    return text if len(text) <= most else text[:most - 3] + "..."


def draw_chart(scene, folder, stem, plt):
    lines = words_of(scene)
    height = 5.6 + 0.16 * len(lines)
    figure = plt.figure(figsize=(11, height), dpi=130)
    grid = figure.add_gridspec(2, 4, left=0.06, right=0.985, top=1 - 0.62 / height,
                               bottom=(0.6 + 0.16 * len(lines)) / height, wspace=0.32, hspace=0.3,
                               width_ratios=[1.25, 1.25, 1, 1])
    places = [grid[:, 0:2], grid[0, 2], grid[0, 3], grid[1, 2], grid[1, 3]]
    for (key, title), place in zip(PANELS, places):
        axes = figure.add_subplot(place)
        draw_panel(axes, scene, key, title, large=key == "position_m")
        if key == "position_m":
            axes.set_xlabel("CPU time, ns per body and simulated second", fontsize=8)
            if axes.lines:
                axes.legend(fontsize=7, framealpha=0.8, loc="best" if scene.get("peers") else "lower left")
    figure.suptitle(f"{pathlib.Path(scene['scene']).name}: {scene['title']}; {scene['bodies']} "
                    f"bodies, {scene['duration_s']:.3g} s. Greatest error against cost; ring: no run "
                    "is better in both; X: failed", x=0.01, ha="left", fontsize=9.5)
    for i, line in enumerate(lines):
        figure.text(0.01, (0.16 * (len(lines) - 1 - i) + 0.06) / height, clip(line), fontsize=7.5,
                    color="#333333")
    for ending in ("svg", "png"):
        save(figure, folder / f"{stem}.{ending}")
    plt.close(figure)


def page_of(chart, names):
    """Small multiples of all scenes."""
    head = html.escape(f"pantin {chart.get('version', '')} ({chart.get('commit', '')}), "
                       f"{chart.get('compiler', '')}, {chart.get('cores', '')} x "
                       f"{chart.get('cpu', '')}, load {chart.get('load', 0):.1f}")
    parts = ["<!doctype html><meta charset=utf-8><title>pantin chart</title><style>"
             "body{font:14px sans-serif;margin:1em}main{display:grid;gap:1em;"
             "grid-template-columns:repeat(auto-fill,minmax(440px,1fr))}img{width:100%}"
             "td,th{padding:0 .7em 0 0;text-align:left;font-size:12px}</style>",
             f"<h1>Cost against error</h1><p>{head}. {html.escape(chart['cost'])}. "
             "<a href=chart.csv>chart.csv</a> <a href=chart.json>chart.json</a></p><main>"]
    for scene, name in zip(chart["scenes"], names):
        rows = "".join(
            f"<tr><td>{html.escape(r['method'])}<td>"
            f"{format(r['tolerance'], '.0e') if r['tolerance'] else format(1e3 * r['step_s'], '.4g') + ' ms'}"
            f"<td>{r['cost_ns']:.0f}<td>{r['position_m']:.1e}"
            for r in sorted((r for r in scene["runs"] + scene.get("peers", []) if r["front"]), key=lambda r: r["cost_ns"]))
        parts.append(f"<section id={html.escape(name)}><h2>{html.escape(scene['title'])}</h2>"
                     f"<a href={html.escape(name)}.svg><img loading=lazy src={html.escape(name)}.png></a>"
                     f"<table><tr><th>best choices<th>step<th>ns/body/s<th>error, m{rows}</table>"
                     "</section>")
    return "\n".join(parts) + "</main>\n"


def draw_charts(folder, plt):
    chart = json.loads((folder / "chart.json").read_text(encoding="utf-8"))
    names = stems(chart["scenes"])
    for scene, name in zip(chart["scenes"], names):
        draw_chart(scene, folder, name, plt)
    write(folder / "index.html", page_of(chart, names))


# The most serious first, as in map.json.
SYMPTOMS = {"refused": "#ffffff", "blows up": "#1a1a1a", "does not converge": "#7b3294",
            "tears": "#d7191c", "gains energy": "#f28e2b", "sinks": "#8c510a",
            "freezes": "#2c7bb6", "jitters": "#f0c808", "stalls": "#a6a6a6", "ok": "#d9f0d3"}


def place_on(axis, part):
    if axis["log"]:
        return axis["from"] * (axis["to"] / axis["from"]) ** part
    return axis["from"] + (axis["to"] - axis["from"]) * part


def draw_one_map(axes, chart, one):
    from matplotlib.patches import Rectangle
    across, up = chart["axes"][0], chart["axes"][1] if len(chart["axes"]) > 1 else None
    size = one["size"]
    for x, y, own, symptom in one["cells"]:
        left, right = (place_on(across, k / size) for k in (x, x + own))
        low, high = (place_on(up, k / size) for k in (y, y + own)) if up else (0, 1)
        axes.add_patch(Rectangle((left, low), right - left, high - low, lw=0,
                                 facecolor=SYMPTOMS[chart["symptoms"][symptom]], antialiased=False,
                                 hatch="///" if chart["symptoms"][symptom] == "refused" else None))
    axes.set_xscale("log" if across["log"] else "linear")
    axes.set_xlim(across["from"], across["to"])
    if up:
        axes.set_yscale("log" if up["log"] else "linear")
        axes.set_ylim(up["from"], up["to"])
    else:
        axes.set_yticks([])
    axes.set_title(one["method"] + ("" if one["complete"] else " (coarse: the time was over)"),
                   fontsize=8.5, loc="left")
    axes.tick_params(labelsize=7)


def draw_map(folder, plt):
    from matplotlib.patches import Patch
    chart = json.loads((folder / "map.json").read_text(encoding="utf-8"))
    maps = chart["maps"]
    columns = min(4, len(maps))
    rows = math.ceil(len(maps) / columns)
    high = 2.5 if len(chart["axes"]) > 1 else 1
    height = rows * (high + 0.35) + 1.25
    figure, grid = plt.subplots(rows, columns, squeeze=False, dpi=130, sharex=True, sharey=True,
                                figsize=(max(5.5, 2.9 * columns + 0.9), height))
    figure.subplots_adjust(left=0.75 / figure.get_figwidth(), right=0.985, bottom=0.85 / height,
                           top=1 - 0.62 / height, wspace=0.08, hspace=0.35 / high)
    for at, axes in enumerate(grid.flat):
        if at < len(maps):
            draw_one_map(axes, chart, maps[at])
        else:
            axes.set_visible(False)
    names = [a["name"] + (", s" if a["name"] == "step" else "") for a in chart["axes"]]
    figure.text(0.5, 0.42 / height, names[0], ha="center", fontsize=8)
    if len(names) > 1:
        figure.text(0.12 / figure.get_figwidth(), 0.5, names[1], va="center", rotation=90, fontsize=8)
    step = "" if any(a["name"] == "step" for a in chart["axes"]) else \
        f", steps of {1e3 * chart['step_s']:.3g} ms"
    figure.suptitle(f"{pathlib.Path(chart['scene']).name}: {chart['title']}; "
                    f"{chart['duration_s']:.3g} s{step}", x=0.01, ha="left", fontsize=9)
    seen = {chart["symptoms"][c[3]] for one in maps for c in one["cells"]}
    figure.legend(handles=[Patch(facecolor=SYMPTOMS[s], label=s, ec="#888888", lw=0.4,
                                 hatch="///" if s == "refused" else None)
                           for s in chart["symptoms"] if s in seen],
                  ncol=5, fontsize=7, loc="lower left", frameon=False, bbox_to_anchor=(0, 0))
    for ending in ("svg", "png"):
        save(figure, folder / f"map.{ending}")
    plt.close(figure)


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in ("chart", "map"):
        print(__doc__.strip(), file=sys.stderr)
        return 2
    try:
        import matplotlib
        matplotlib.use("Agg")
        import matplotlib.pyplot as plt
    except ImportError:
        # Another python3 is first in the path, and the system's may have it.
        if os.path.exists(SYSTEM) and sys.executable != SYSTEM:
            os.execv(SYSTEM, [SYSTEM, "-B", *sys.argv])
        print("pantin: no pictures: python3 found no matplotlib (Debian package python3-matplotlib); "
              "all numbers are written", file=sys.stderr)
        return 77
    matplotlib.rcParams["svg.hashsalt"] = "pantin"
    folder = pathlib.Path(sys.argv[2])
    draw_charts(folder, plt) if sys.argv[1] == "chart" else draw_map(folder, plt)
    return 0


if __name__ == "__main__":
    sys.exit(main())
