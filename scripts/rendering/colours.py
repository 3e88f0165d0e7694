"""The colours of bodies: by their numbers, their material, their height or their speed."""
import numpy as np

KINDS = ('id', 'material', 'height', 'speed')
BACKGROUND = np.array([0.957, 0.965, 0.976])
PALETTE = np.array([[0x3B, 0x6E, 0x8F], [0x5F, 0xA8, 0xA1], [0xE9, 0xC4, 0x6A], [0xF0, 0x9A, 0x56], [0xD9, 0x5F, 0x4C],
                    [0x8F, 0xB3, 0xC9], [0xF2, 0xE3, 0xC6]]) / 255.0
RAMP = np.array([[0x2B, 0x4C, 0x7E], [0x3F, 0x88, 0xA8], [0x7F, 0xC1, 0xA8], [0xF2, 0xD2, 0x7B], [0xE7, 0x6F, 0x51]]) / 255.0
NOT_DYNAMIC = [0.62, 0.64, 0.67]


def colours(kind, bodies, position, velocity, bottom, top):
    """RGB of each body, 0..1. bottom, top (m): of the scene."""
    if kind == 'id':
        rgb = by_number(bodies.count)
    elif kind == 'material':
        rgb = PALETTE[(2 * bodies.material) % len(PALETTE)]
    elif kind == 'height':
        rgb = on_ramp(position[:, 2], bottom, top)
    else:
        speed = np.linalg.norm(velocity, axis=1)
        rgb = on_ramp(speed, 0, max(1e-9, np.nanpercentile(speed[bodies.dynamic], 98)))
    return np.clip(np.where(bodies.dynamic[:, None], rgb, NOT_DYNAMIC), 0, 1)


def by_number(count):
    """One of the palette's, a little lighter or darker: by a hash, so that neighbours differ."""
    number = np.arange(count, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    rgb = PALETTE[(number >> np.uint64(40)) % np.uint64(len(PALETTE))]
    tint = ((number >> np.uint64(20)) % np.uint64(256)).astype(float) / 255 - 0.5
    return rgb * (1 + 0.16 * tint[:, None])


def on_ramp(value, start, end):
    value = np.nan_to_num(value)  # of bodies that are absent
    t = np.clip((value - start) / max(1e-9, end - start), 0, 1) * (len(RAMP) - 1)
    return np.stack([np.interp(t, range(len(RAMP)), RAMP[:, c]) for c in range(3)], 1)


def of_surface(number):
    """Of a cloth or thread by its number."""
    return PALETTE[(3 * number) % len(PALETTE)]
