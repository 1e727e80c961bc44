"""Scenes that `vitrine run` made, as numpy arrays: cameras, surfels, objects, mesh; pictures, light and gradients.

    import vitrine
    scene = vitrine.open("out")                    # an output folder of `vitrine run`
    picture = scene.render(scene.cameras[0])       # picture.srgb [h, w, 3], .depth, .normals, .alpha
    scene.surfels["diffuse"].opacities             # [n]; assign to change the scene
    scene.gradient(scene.cameras[0], d_picture)    # dL/d(raw attributes)
    scene.relight(environment).render(camera)      # under a lat-long map [h, 2 h, 3]

Lengths are in scene units (the ring of the photos' cameras has the radius 1), up is +z, colours are linear Rec. 709
unless named srgb. Errors are vitrine.Error, with the text that the programs print.
"""

from ._vitrine import (
    Camera,
    Error,
    Mesh,
    Picture,
    Relighting,
    RelitPicture,
    Scene,
    Surfels,
    __version__,
    develop,
    open,
    set_threads,
)

__all__ = [
    "Camera", "Error", "Mesh", "Picture", "Relighting", "RelitPicture", "Scene", "Surfels",
    "develop", "open", "set_threads",
]
