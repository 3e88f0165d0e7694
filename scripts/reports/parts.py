"""The parts of the report, in order: name on the command line -> module with TITLE and make(maker) -> Section."""
import contact_problems
import damping
import discs
import hanging_cloth
import published_tables
import rivals
import sliding
import torus
import velocity_level
import work_precision

PARTS = {
    'published_tables': published_tables, 'sliding': sliding, 'torus': torus, 'velocity_level': velocity_level, 'discs': discs,
    'hanging_cloth': hanging_cloth, 'damping': damping, 'work_precision': work_precision, 'rivals': rivals,
    'contact_problems': contact_problems}
# Of two idle cores, roughly, by size of the report.
MINUTES = {'quick': dict(zip(PARTS, (.9, .3, .5, 1.1, .8, .3, .2, 5, 4.5, .7))),
           'full': dict(zip(PARTS, (4, .3, .5, 1.1, 10, .6, .6, 45, 120, 5)))}
