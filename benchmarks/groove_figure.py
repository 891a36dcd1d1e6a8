"""Draws haptics/proxy/groove.svg: the steps of a proxy that slides into a groove.

The groove is two walls through the origin, in millimetres and in the plane across the groove. The
steps are computed as the god-object takes them: the goal is projected onto the contact planes, and
the first wall in the way stops the proxy a stand-off before and adds its plane. In the plane each
step has a closed form.
"""

import math

import svg

WALL_SLOPES_DEG = (-36.0, 50.0)  # of the left and of the right wall
STAND_OFF_MM = 0.75  # much larger than the engine's, to be visible
OLD_PROXY_MM = (-5.6, 8.2)
GOAL_MM = (0.7, -4.6)

LOW_MM = (-8.2, -5.6)
HIGH_MM = (6.2, 9.4)
PX_PER_MM = 36.0
TOP = 16
MARGIN = 16
TEXT_LEFT = 556
WIDTH = 960

PROXY = svg.BLUE
GOAL = svg.RED
PLANES = (svg.GREEN, svg.ORANGE)
SOLID = svg.FAINT
MUTED = svg.INK


# Steps

def normals():
    """Of both walls, into the free space."""
    return [(-math.sin(math.radians(a)), math.cos(math.radians(a))) for a in WALL_SLOPES_DEG]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1]


def minus(a, b):
    return a[0] - b[0], a[1] - b[1]


def height(point, normal):
    """Over the plane that lies a stand-off in front of the wall."""
    return dot(point, normal) - STAND_OFF_MM


def stopped_at(start, end, normal):
    """Where the segment meets the plane."""
    first, last = height(start, normal), height(end, normal)
    fraction = first / (first - last)
    return tuple(s + fraction * (e - s) for s, e in zip(start, end))


def projected(point, normal):
    return tuple(p - height(point, normal) * n for p, n in zip(point, normal))


def multipliers(lag, first, second):
    """(a, b) with lag = -a first - b second. Both are positive if and only if no direction that
    neither plane forbids leads nearer to the goal: the certificate."""
    determinant = first[0] * second[1] - first[1] * second[0]
    return ((-lag[0] * second[1] + lag[1] * second[0]) / determinant,
            (-first[0] * lag[1] + first[1] * lag[0]) / determinant)


def steps():
    """The old proxy, where the first wall stops it, the nearest point of plane 1 to the goal, and the
    rest."""
    first, second = normals()
    stopped = stopped_at(OLD_PROXY_MM, GOAL_MM, first)
    nearest = projected(GOAL_MM, first)
    rest = stopped_at(stopped, nearest, second)
    assert min(multipliers(minus(GOAL_MM, rest), first, second)) > 0.0
    return OLD_PROXY_MM, stopped, nearest, rest


# Picture

TEXT = [
    ("1", "The tick starts at the old proxy. The goal, the device's point in the scene, lies inside "
          "the solid."),
    ("2", "The proxy moves straight towards the goal. The first wall stops it a stand-off before the "
          "surface and adds contact plane 1."),
    ("3", "The proxy slides along plane 1 towards the point of the plane that is nearest to the goal."),
    ("4", "The second wall stops the slide a stand-off before its surface and adds contact plane 2."),
    ("5", "The proxy rests at the nearest point to the goal that neither plane forbids. Certificate: "
          "the lag, from proxy to goal, lies between the directions into both walls (shaded), so no "
          "free direction leads nearer to the goal."),
]


def place(point):
    return (MARGIN + PX_PER_MM * (point[0] - LOW_MM[0]), TOP + PX_PER_MM * (HIGH_MM[1] - point[1]))


def along(point, direction, distance):
    return point[0] + distance * direction[0], point[1] + distance * direction[1]


def draw():
    old, stopped, nearest, rest = steps()
    first, second = normals()
    picture = svg.Drawing(WIDTH, math.ceil(2 * TOP + PX_PER_MM * (HIGH_MM[1] - LOW_MM[1])),
                          "A proxy slides into a groove in five steps")
    draw_walls(picture)
    draw_planes(picture, rest, (first, second))
    draw_certificate(picture, rest, (first, second))

    picture.line([place(stopped), place(GOAL_MM)], MUTED, 1.5, "2 5")
    picture.line([place(GOAL_MM), place(nearest)], MUTED, 1.5, "2 5")
    picture.line([place(rest), place(nearest)], MUTED, 1.5, "2 5")
    picture.circle(place(nearest), 5, "none", MUTED, 1.5)
    picture.arrow(place(old), place(stopped), PROXY, 3.5)
    picture.arrow(place(stopped), place(rest), PROXY, 3.5)
    picture.arrow(place(rest), place(GOAL_MM), GOAL, 2.5)
    picture.circle(place(GOAL_MM), 7, GOAL)
    draw_labels(picture, old, stopped, nearest, rest)
    y = TOP + 26
    picture.text((TEXT_LEFT, y), "A slide into a groove", 22, bold=True)
    y += 34
    for number, text in TEXT:
        badge(picture, (TEXT_LEFT + 11, y - 5), number)
        y = picture.paragraph((TEXT_LEFT + 32, y), text, WIDTH - MARGIN - TEXT_LEFT - 32, 17) + 8
    y = picture.paragraph((TEXT_LEFT, y + 6),
                      "Section across the groove. The stand-off is drawn far too large: in the engine "
                      "it is invisible.", WIDTH - MARGIN - TEXT_LEFT, 17, MUTED)
    picture.height = max(picture.height, math.ceil(y))
    return picture.svg()


def draw_walls(picture):
    def wall_at(x, slope_deg):
        return x, x * math.tan(math.radians(slope_deg))
    left, right = wall_at(LOW_MM[0], WALL_SLOPES_DEG[0]), wall_at(HIGH_MM[0], WALL_SLOPES_DEG[1])
    corners = [left, (0.0, 0.0), right, (HIGH_MM[0], LOW_MM[1]), LOW_MM]
    picture.polygon([place(p) for p in corners], SOLID)
    picture.line([place(p) for p in (left, (0.0, 0.0), right)], svg.INK, 3)


def draw_planes(picture, rest, both):
    """Dashed, from beyond the rest to the border, each with its number."""
    for n, (normal, border) in enumerate(zip(both, (LOW_MM[0], HIGH_MM[0]))):
        direction = (normal[1], -normal[0])
        end = along(rest, direction, (border - rest[0]) / direction[0])
        beyond = along(rest, direction, -1.6 if border > rest[0] else 1.6)
        picture.line([place(beyond), place(end)], PLANES[n], 2, "9 6")


def draw_certificate(picture, rest, both):
    reach = 2.0
    angles = [math.atan2(-normal[1], -normal[0]) for normal in both]
    centre = place(rest)
    picture.polygon([centre] + svg.arc(centre, reach * PX_PER_MM, *angles), svg.RED + "33")
    for n, normal in enumerate(both):
        picture.arrow(centre, place(along(rest, normal, -reach)), PLANES[n], 2.5)


def badge(picture, centre, number):
    picture.circle(centre, 11, PROXY)
    picture.text((centre[0], centre[1] + 6), number, 17, "#ffffff", "middle", True)


def draw_labels(picture, old, stopped, nearest, rest):
    first, second = normals()
    middle = tuple((a + b) / 2 for a, b in zip(stopped, rest))
    badge(picture, place(old), "1")
    badge(picture, place(stopped), "2")
    badge(picture, place(along(middle, first, 0.55)), "3")
    badge(picture, place(along(along(rest, first, 0.45), second, 0.45)), "4")
    badge(picture, place(rest), "5")
    x, y = place(old)
    picture.text((x + 18, y + 5), "old proxy", 17, PROXY, bold=True)
    x, y = place(GOAL_MM)
    picture.text((x + 14, y + 6), "goal", 17, GOAL, bold=True)
    x, y = place(nearest)
    right = place(HIGH_MM)[0] - 4
    picture.text((right, y + 24), "nearest point", 17, MUTED, "end")
    picture.text((right, y + 44), "of plane 1", 17, MUTED, "end")
    x, y = place((-8.0, 7.3))
    picture.text((x, y), "plane 1", 17, PLANES[0], bold=True)
    x, y = place((4.7, 8.0))
    picture.text((x, y), "plane 2", 17, PLANES[1], "end", True)
    # The stand-off, measured off on the right wall.
    foot = along((0.0, 0.0), (second[1], -second[0]), 6.2)
    picture.arrow(place(foot), place(along(foot, second, STAND_OFF_MM)), svg.INK, 1.5, True)
    x, y = place(foot)
    picture.text((right, y + 26), "stand-off", 17, svg.INK, "end")
    x, y = place((-7.6, 2.4))
    picture.text((x, y), "solid", 17, MUTED)
