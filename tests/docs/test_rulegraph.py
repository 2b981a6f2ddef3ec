"""The picture of a graph without graphviz."""

import xml.etree.ElementTree as ElementTree

import rulegraph


def test_an_edge_that_a_longer_way_says_is_left_out():
    assert rulegraph.reduced({("a", "b"), ("b", "c"), ("a", "c")}) == {("a", "b"), ("b", "c")}


def test_every_node_stands_below_what_it_reads():
    edges = rulegraph.FLOW
    rank = rulegraph.ranks(edges)
    assert all(rank[a] < rank[b] for a, b in edges)
    assert min(rank.values()) == 0


def test_boxes_of_a_row_do_not_overlap():
    edges = rulegraph.FLOW
    rank = rulegraph.ranks(edges)
    place = rulegraph.placed(rulegraph.stepped(edges, rank), rank)
    for row in {row for _, row in place.values()}:
        nodes = sorted((node for node in place if place[node][1] == row), key=lambda node: place[node][0])
        for a, b in zip(nodes, nodes[1:], strict=False):
            room = (rulegraph.box_width(a) + rulegraph.box_width(b)) / 2
            # Sums of a few widths: rounding is far below a thousandth of a pixel.
            assert place[b][0] - place[a][0] >= room - 1e-3


def test_the_picture_is_xml_with_every_node_once():
    picture = ElementTree.fromstring(rulegraph.svg(rulegraph.FLOW, "flow"))
    texts = [element.text for element in picture.iter("{http://www.w3.org/2000/svg}text")]
    assert sorted(texts) == sorted({node for edge in rulegraph.FLOW for node in edge})


def test_every_rule_of_the_default_target_stands_in_a_rules_file():
    edges = rulegraph.read_rules()
    names = {name for edge in edges for name in edge}
    assert {"fit_statistics", "render_phy", "train_cgan", "train_tracker"} <= names
    assert names <= set(rulegraph.stage_of_rules())
    assert "render_phy" not in rulegraph.mermaid(edges)
    assert "    statistics --> phy\n" in rulegraph.mermaid(edges)
