"""The table as one page: family x solver x rate."""
import collections
import html
import math

HEAD = """<!doctype html><meta charset="utf-8"><title>Truth table</title>
<style>
:root { --ground: #fff; --ink: #1d1f21; --line: #d9d9d9; --green: #3a9a5b; --told: #e2a73a; --red: #c9413c; --none: #f1f1f1 }
@media (prefers-color-scheme: dark) {
  :root { --ground: #191b1d; --ink: #dfe1e3; --line: #3a3d40; --none: #26292c } }
body { background: var(--ground); color: var(--ink); font: 14px/1.4 system-ui, sans-serif; margin: 2em; max-width: 90em }
table { border-collapse: collapse } th { font-weight: 500; text-align: left; padding: 2px 8px }
td { border: 1px solid var(--line); padding: 0 }
tr:hover th { text-decoration: underline } i { display: inline-block; width: 15px; height: 15px; vertical-align: middle }
.cells { white-space: nowrap; padding: 2px 4px } .green { background: var(--green) } .told { background: var(--told) }
.red { background: var(--red) } .known { outline: 2px dotted var(--ink); outline-offset: -3px }
.small { opacity: .75; font-size: 12px } .old { height: 7px; margin-right: -15px; position: relative; top: -11px }
details { margin: .3em 0 } thead th { position: sticky; top: 0; background: var(--ground) }
</style>
"""


def square(cell, kind=""):
    known = " known" if cell.known and cell.verdict == "red" else ""
    found = f"\ntold: {'; '.join(cell.found[:4])}" if cell.found else ""
    ratio = f" ({cell.ratio:.2g} of the bound)" if math.isfinite(float(cell.ratio)) else ""
    text = f"{cell.family}, {cell.solver}, {cell.rate}: {cell.verdict}\n{cell.said}{ratio}{found}"
    if cell.known:
        text += f"\nknown: {cell.known}"
    text = html.escape(text, quote=True).replace("\n", "&#10;")
    return f'<i class="{cell.verdict}{known} {kind}" title="{text}"></i>'


def counted(cells, name):
    count = collections.Counter(c.verdict for c in cells)
    return (f"<p>{name}: {len(cells)} cells, <b>{count['green']}</b> green, <b>{count['told']}</b> told, "
            f"<b>{count['red']}</b> red.</p>")


def drawn(found, cells, before=None):
    """The page. With a table of an older program its cells stand above the present ones."""
    parts = [HEAD, "<h1>Truth table</h1><p>Every family of scenes under every solver; squares from left to right: "
             "60, 240, 960 steps a second, or those that are named where the mouse rests. Green: within its bounds. "
             "Amber: not, and a finding, the status or a refusal names it. Red: wrong, and the run says ok.</p>"]
    if before is not None:
        parts.append(counted(before, "Before (upper row)") + counted(cells, "Now (lower row)"))
    else:
        parts.append(counted(cells, "Now"))
    by = collections.defaultdict(list)
    old = collections.defaultdict(list)
    for cell in cells:
        by[cell.family, cell.solver].append(cell)
    for cell in before or []:
        old[cell.family, cell.solver].append(cell)
    solvers = list(dict.fromkeys(cell.solver for cell in cells))
    heads = "".join(f"<th>{html.escape(s)}</th>" for s in solvers)
    parts.append(f"<table><thead><tr><th>family</th>{heads}<th></th></tr></thead>")
    for family in found:
        row = []
        for solver in solvers:
            upper = "".join(square(c) for c in old.get((family.name, solver), []))
            lower = "".join(square(c) for c in by.get((family.name, solver), []))
            row.append(f'<td class="cells">{upper + "<br>" if upper else ""}{lower}</td>')
        about = html.escape(family.told["about"])
        parts.append(f'<tr><th>{html.escape(family.name)}</th>{"".join(row)}<th class="small">{about}</th></tr>')
    parts.append("</table>")
    wrong = [c for c in cells if c.verdict == "red"]
    if wrong:
        lines = "".join(f"<li>{html.escape(f'{c.family}, {c.solver}, {c.rate}: {c.said}')}"
                        f"{' <i>' + html.escape(c.known) + '</i>' if c.known else ''}</li>" for c in wrong)
        parts.append(f"<details open><summary>Red cells</summary><ul>{lines}</ul></details>")
    return "\n".join(parts)
