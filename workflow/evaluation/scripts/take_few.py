"""The first scenes of a set: they are spread over the line, and the first of more hold them."""

from main_path import run

from snowsim.io.scenes import SceneSet, write_scenes


def take_few(scenes, few, *, n_scenes):
    with SceneSet(scenes) as annotated:
        attributes = {"synthetic": annotated.attributes["synthetic"]}
        write_scenes(few, (annotated[item] for item in range(n_scenes)), attributes)


run(take_few)
