"""Files of cubes and panoramas for tests."""

import struct

import numpy as np

from envlights._common.srgb import encode_srgb


def dds(path, faces, sides=0xFE00):
    """Uncompressed 8-bit DDS cube of faces as they are stored, (6, n, n, 3), in linear light."""
    codes = np.rint(encode_srgb(faces.clip(0, 1)) * 255).astype(np.uint8)
    count, n = codes.shape[:2]
    header = b"DDS " + struct.pack("<7I", 124, 0x100F, n, n, 4 * n, 0, 0) + bytes(44)
    header += struct.pack("<8I", 32, 0x41, 0, 32, 0xFF0000, 0xFF00, 0xFF, 0xFF000000)
    header += struct.pack("<5I", 0x1008, sides, 0, 0, 0)
    pixels = np.dstack([codes[..., ::-1].reshape(count * n, n, 3), np.full((count * n, n), 255)])
    path.write_bytes(header + pixels.astype(np.uint8).tobytes())
    return path


def xmp(**properties):
    """XMP packet with GPano and GSpherical properties."""
    said = " ".join(f'{key.replace("__", ":")}="{value}"' for key, value in properties.items())
    return (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF'
        ' xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"><rdf:Description'
        ' xmlns:GPano="http://ns.google.com/photos/1.0/panorama/"'
        f' xmlns:GSpherical="http://ns.google.com/videos/1.0/spherical/" {said}'
        "/></rdf:RDF></x:xmpmeta>"
    ).encode()


def jpeg_with(path, samples, **properties):
    """JPEG picture of linear samples with an XMP packet."""
    import OpenImageIO as oiio  # noqa: N813, its own name for itself

    codes = np.rint(encode_srgb(samples.clip(0, 1)) * 255).astype(np.uint8)
    height, width, _ = codes.shape
    spec = oiio.ImageSpec(width, height, 3, "uint8")
    spec.attribute("Compression", "jpeg:100")
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    assert file.write_image(codes)
    file.close()
    data = path.read_bytes()
    packet = b"http://ns.adobe.com/xap/1.0/\0" + xmp(**properties)
    segment = b"\xff\xe1" + struct.pack(">H", len(packet) + 2) + packet
    path.write_bytes(data[:2] + segment + data[2:])
    return path
