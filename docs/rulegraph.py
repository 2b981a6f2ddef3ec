"""The workflow's graph of rules as a picture, drawn without graphviz: SVG of all rules, mermaid of the stages.

``python docs/rulegraph.py > rules.svg`` draws the rules; ``python docs/rulegraph.py mermaid`` prints the stages. The
documentation draws both when it is built.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SNAKEMAKE = Path(sys.executable).with_name("snakemake")

# What flows between the stages, for the picture of the concept.
FLOW = {
    ("sample flight", "flight statistics"),
    ("flight statistics", "label sets"),
    ("flight statistics", "PHY renders"),
    ("label sets", "PHY renders"),
    ("label sets", "cGAN renders"),
    ("benchmark: train", "cGAN"),
    ("cGAN", "cGAN renders"),
    ("benchmark: test", "similarity, Table II"),
    ("PHY renders", "similarity, Table II"),
    ("cGAN renders", "similarity, Table II"),
    ("PHY renders", "trackers"),
    ("cGAN renders", "trackers"),
    ("benchmark: train", "trackers"),
    ("trackers", "edge scores, Table III"),
    ("benchmark: test", "edge scores, Table III"),
}

GAP, ROW, CHARACTER, HEIGHT, WAY = 16, 50, 6.4, 21, 10  # [px]
N_SWEEPS = 24
# A rule by its header, and those made in a loop by the name they are given, without what tells them apart.
RULE_NAME = re.compile(
    r'^ *(?:rule|checkpoint) (\w+):|^ *use rule \w+ as (\w+)|^ *name:\s+(?:f")?(\w+?)(?:_{\w+}")?$', re.MULTILINE
)


def read_rules():
    """Edges of the default target's graph of rules, set of (rule, rule that reads it); targets left out."""
    with tempfile.TemporaryDirectory() as folder:
        command = [SNAKEMAKE, "--snakefile", ROOT / "Snakefile", "--directory", folder, "--rulegraph"]
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, cwd=folder)
    if done.returncode:
        msg = f"snakemake --rulegraph failed: {done.stderr.strip().splitlines()[-1:]}"
        raise ValueError(msg)
    # Rules of one script, made in a loop, end with a number, or are the plots of a stage: one node.
    labels = re.findall(r'(\d+)\[label = "(\w+)', done.stdout)
    names = {number: re.sub(r"_\d{4}$|(?<=^plot)_\w+$", "", name) for number, name in labels}
    edges = {(names[a], names[b]) for a, b in re.findall(r"(\d+) -> (\d+)", done.stdout)}
    return {edge for edge in edges if edge[1] != "all"}


def stage_of_rules():
    """Name of the rules file that each rule stands in."""
    stages = {}
    for path in (ROOT / "Snakefile", *sorted((ROOT / "workflow/rules").glob("*.smk"))):
        for names in RULE_NAME.findall(path.read_text()):
            stages["".join(names)] = path.stem
    return stages


def reduced(edges):
    """Edges without those that a longer way already says."""
    after = {}
    for a, b in edges:
        after.setdefault(a, set()).add(b)

    def reached(node, seen):
        for following in after.get(node, ()):
            if following not in seen:
                seen.add(following)
                reached(following, seen)
        return seen

    return {(a, b) for a, b in edges if not any(b in reached(other, set()) for other in after[a] - {b})}


def ranks(edges):
    """Row of each node: the longest way to it from a node without input."""
    rank = dict.fromkeys((node for edge in edges for node in edge), 0)
    for _ in range(len(rank)):
        for a, b in edges:
            rank[b] = max(rank[b], rank[a] + 1)
    return rank


def stepped(edges, rank):
    """Edges as chains of steps from row to row, list of lists of nodes; a step between is (edge, row)."""
    return [[a, *(((a, b), row) for row in range(rank[a] + 1, rank[b])), b] for a, b in sorted(edges)]


def placed(chains, rank):
    """Centre of every node and step between, dict to (x, row): rows sorted by where neighbours lie."""
    row_of = {node: node[1] if isinstance(node, tuple) else rank[node] for chain in chains for node in chain}
    rows = [sorted((n for n in row_of if row_of[n] == row), key=str) for row in range(max(row_of.values()) + 1)]
    beside = {node: [] for node in row_of}
    for chain in chains:
        for a, b in zip(chain, chain[1:], strict=False):
            beside[a].append(b)
            beside[b].append(a)
    at = {}
    for sweep in range(N_SWEEPS):
        for row in rows if sweep % 2 == 0 else reversed(rows):
            wanted = {n: [at[m] for m in beside[n] if m in at and (sweep > 1 or row_of[m] < row_of[n])] for n in row}
            wanted = {n: sum(x) / len(x) if x else at.get(n, 0.0) for n, x in wanted.items()}
            row.sort(key=lambda n: wanted[n])  # noqa: B023
            left = 0.0
            for node in row:
                at[node] = left + box_width(node) / 2
                left += box_width(node) + GAP
            # Close together, in the middle of where their neighbours would have them.
            shift = sum(wanted[n] - at[n] for n in row) / len(row)
            at.update({n: at[n] + shift for n in row})
    leftmost = min(at[n] - box_width(n) / 2 for n in at)
    return {n: (at[n] - leftmost, row_of[n]) for n in at}


def box_width(node):
    """Width of a node's box, or of the room of a step between [px]."""
    return WAY if isinstance(node, tuple) else CHARACTER * len(node) + 14


def svg(edges, title):
    """Picture of a graph without cycles, from top to bottom, as SVG text."""
    chains = stepped(edges, ranks(edges))
    place = placed(chains, ranks(edges))
    boxes = [node for node in place if not isinstance(node, tuple)]
    width = max(place[node][0] + box_width(node) / 2 for node in place) + 8
    height = ROW * max(row for _, row in place.values()) + HEIGHT + 8
    at = {node: (x + 4, row * ROW + HEIGHT / 2 + 4) for node, (x, row) in place.items()}
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" role="img" '
        f'aria-label="{title}" style="width:{width:.0f}px;max-width:100%;min-width:{0.8 * width:.0f}px;height:auto" '
        f'font-family="sans-serif" font-size="11"><title>{title}</title>'
    ]
    for chain in chains:
        points = [at[node] for node in chain]
        path = f"M{points[0][0]:.0f} {points[0][1]:.0f}"
        for (x0, y0), (x1, y1) in zip(points, points[1:], strict=False):
            middle = (y0 + y1) / 2
            path += f"C{x0:.0f} {middle:.0f} {x1:.0f} {middle:.0f} {x1:.0f} {y1:.0f}"
        parts.append(f'<path d="{path}" fill="none" stroke="#8a8f98" stroke-width="1.2"/>')
    for node in sorted(boxes):
        x, y = at[node]
        left, top = x - box_width(node) / 2, y - HEIGHT / 2
        parts.append(
            f'<rect x="{left:.0f}" y="{top:.1f}" width="{box_width(node):.0f}" height="{HEIGHT}" rx="5" '
            'fill="#eef4fb" stroke="#2f6db3"/>'
            f'<text x="{x:.0f}" y="{y + 4:.1f}" text-anchor="middle" fill="#10243c">{node}</text>'
        )
    return "".join(parts) + "</svg>\n"


def mermaid(edges):
    """Flowchart of the stages, that is, of the files the rules stand in, as mermaid text."""
    stages = stage_of_rules()
    between = {(stages[a], stages[b]) for a, b in edges if stages[a] != stages[b]}
    return "\n".join(["flowchart LR", *(f"    {a} --> {b}" for a, b in sorted(between))]) + "\n"


if __name__ == "__main__":
    rules = read_rules()
    sys.stdout.write(mermaid(rules) if sys.argv[1:] == ["mermaid"] else svg(reduced(rules), "graph of rules"))
