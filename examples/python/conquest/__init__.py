"""Progressive to lossless coding of triangle meshes. SPDX-License-Identifier: MIT

    data = conquest.encode(vertices, faces, normals=normals)
    mesh = conquest.decode(data)                       # mesh.vertices, mesh.faces, mesh.attributes["normals"]
    mesh = conquest.decode(data[:5000], partial=True)  # what the first 5000 bytes show

conquest.Decoder decodes bytes as they arrive. After conquest.register(), trimesh and meshio read and write .cqm files.
"""

from ._conquest import ffi as _ffi, lib as _lib
from .decoder import Decoder, Mesh, decode
from .encoder import encode
from .errors import Error, LossWarning, MeshError, StreamError, TruncatedError
from .formats import register

__version__: str = _ffi.string(_lib.CQ_VERSION_STRING).decode()
__all__ = ["Decoder", "Error", "LossWarning", "Mesh", "MeshError", "StreamError", "TruncatedError", "decode", "encode",
           "register"]
