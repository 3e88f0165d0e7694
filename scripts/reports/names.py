"""The parts of the report, in order, by their names on the command line, each a module; known before anything is built or imported."""
NAMES = (
    'published_tables', 'sliding', 'torus', 'velocity_level', 'discs', 'hanging_cloth', 'damping', 'work_precision', 'rivals',
    'contact_problems')
# Of two idle cores, roughly, by size of the report.
MINUTES = {'quick': dict(zip(NAMES, (.8, .2, .6, 1.2, 1.4, .3, .2, 5.3, 4.2, .4))),
           'full': dict(zip(NAMES, (4, .3, 1, 1, 24, .5, .4, 24, 78, 4)))}
