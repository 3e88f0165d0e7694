"""The parts of the report, in order: name on the command line -> module with TITLE and make(session) -> Section."""
import sliding

PARTS = {'sliding': sliding}
