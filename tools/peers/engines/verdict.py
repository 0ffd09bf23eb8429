"""What the rows of tools/peers/motion say: the cheapest of each engine at an error, and a chart."""
import math

ERRORS = [10.0 ** -k for k in range(1, 11)]
# Okabe and Ito's colours, as in tools/chart.
LOOKS = {"pantin": ("#D55E00", "o"), "bullet": ("#E69F00", "v"), "ode": ("#999999", "s"),
         "box2d": ("#7A5C00", "P"), "jolt": ("#0072B2", "s"), "rapier": ("#CC79A7", "^"),
         "mujoco": ("#009E73", "D"), "exudyn": ("#56B4E9", "X"), "simbody": ("#6A3D9A", "<"),
         "pinocchio": ("#000000", "*")}


def ladders(rows, scene):
    """By engine and method: points (cost in ms for a second, error in m), the coarsest first."""
    found = {}
    for r in rows:
        if r["scene"] == scene and r["status"] == "ok" and r["cpu_ms_per_s"]:
            key = r["engine"], r["method"]
            found.setdefault(key, []).append((-float(r["step_s"]), -float(r["tolerance"] or 0),
                                              float(r["cpu_ms_per_s"]), float(r["error_m"])))
    return {key: [(cost, error) for *_, cost, error in sorted(points)] for key, points in found.items()}


def cost_at(points, error):
    """The least cost of a run with at most this error; between two neighbours of a ladder that enclose it,
    along the straight line of logarithms."""
    least = min((cost for cost, e in points if e <= error), default=math.inf)
    for (c, e), (d, f) in zip(points, points[1:]):
        if f < error < e and d > 0 and c > 0 and f > 0:
            part = math.log(e / error) / math.log(e / f)
            least = min(least, math.exp((1 - part) * math.log(c) + part * math.log(d)))
    return least


def cheapest(found, error, ours):
    """(cost, engine, method) of ours, or of all others."""
    return min(((cost_at(points, error), *key) for key, points in found.items()
                if (key[0] == "pantin") == ours), default=(math.inf, "", ""))


def short(cost):
    return "-" if math.isinf(cost) else f"{cost:.3g}"


def verdict(rows):
    """By scene and error that the reference can tell: our least cost, and the least of others."""
    for scene in dict.fromkeys(r["scene"] for r in rows):
        found = ladders(rows, scene)
        own = max(float(r.get("reference_m") or 0) for r in rows if r["scene"] == scene)
        for error in (e for e in ERRORS if e > own):
            yield scene, error, cheapest(found, error, True), cheapest(found, error, False)


def show(rows):
    told = {(r["engine"], r["version"], r["settings"], r["method"]) for r in rows if r["version"]}
    for engine, version, settings, method in sorted(told):
        print(f"{engine} {version}, {method}: {settings}")
    print("\nLeast CPU ms for a simulated second; ratio: of the others' to ours, from 1.25 on as asked")
    scene = None
    for name, error, (cost, _, method), (other, engine, others) in verdict(rows):
        if name != scene:
            scene = name
            own = next((r["reference_m"] for r in rows if r["scene"] == name), "")
            print(f"\n{name} (the reference is known to {float(own or 0):.0e} m)\n"
                  "| error, m | pantin | | best other | | ratio |\n|---|---|---|---|---|---|")
        ratio = "-" if math.isinf(cost) and math.isinf(other) else \
            "only others" if math.isinf(cost) else "only pantin" if math.isinf(other) else \
            f"{other / cost:.2f}" + ("" if other >= 1.25 * cost else " (behind)")
        print(f"| {error:.0e} | {short(cost)} | {method} | {short(other)} | {engine} {others} | {ratio} |")


def front(points):
    """Those to which no other is superior."""
    return [(c, e) for c, e in points if not any((d < c and f <= e) or (d <= c and f < e) for d, f in points)]


def draw(rows, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    columns = 4 if len(scenes) > 4 else len(scenes)
    lines = math.ceil(len(scenes) / columns)
    figure, grid = plt.subplots(lines, columns, figsize=(3.9 * columns, 3.6 * lines + 0.5), dpi=110,
                                squeeze=False)
    for axes, scene in zip(grid.flat, scenes):
        found = ladders(rows, scene)
        for engine, (colour, mark) in LOOKS.items():
            points = [p for key, ladder in found.items() if key[0] == engine for p in ladder if p[1] > 0]
            best = sorted(front(points))
            own = engine == "pantin"
            axes.plot(*(zip(*points) if points else ([], [])), mark, color=colour, ms=2.5, alpha=0.35)
            axes.plot(*(zip(*best) if best else ([], [])), marker=mark, color=colour,
                      ms=5 if own else 4, lw=2.2 if own else 1.1, zorder=3 if own else 2, label=engine)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_ylim(1e-13, 10)
        axes.grid(True, which="major", color="#dddddd", lw=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.tick_params(labelsize=8)
        axes.set_title(scene, loc="left", fontsize=10)
    for axes in grid.flat[len(scenes):]:
        axes.set_visible(False)
    for axes in grid[-1]:
        axes.set_xlabel("CPU ms for a simulated second", fontsize=8.5)
    for line in grid:
        line[0].set_ylabel("greatest error of a place, m", fontsize=8.5)
    handles, labels = grid[0][0].get_legend_handles_labels()
    spare = grid.flat[len(scenes)] if len(scenes) < columns * lines else None
    if spare is not None:
        spare.set_visible(True)
        spare.axis("off")
        spare.legend(handles, labels, fontsize=9, frameon=False, loc="center left")
    else:
        figure.legend(handles, labels, fontsize=8.5, frameon=False, loc="lower center", ncol=len(labels))
    figure.suptitle("Cost against error beside other engines: lower left is better; lines join the best runs "
                    "of an engine, whatever its method", x=0.01, ha="left", fontsize=11)
    figure.tight_layout()
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(path.name + ".part")
    figure.savefig(part, format="png")
    part.replace(path)
