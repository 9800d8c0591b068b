"""Names of the room, each with its home."""

from ...base.number_text import number as number
from ...base.number_text import percent as percent
from .csv_files import as_csv as as_csv
from .csv_files import columns as columns
from .csv_files import ending as ending
from .csv_files import write_csv as write_csv
from .library_words import in_options as in_options
from .library_words import without_calls as without_calls
from .output_files import check_writable as check_writable
from .output_files import sentence as sentence
from .output_files import slug as slug
from .output_files import staged as staged
from .output_files import write_all as write_all
from .progress import Progress as Progress
from .progress import finished as finished
from .progress import fitted as fitted
from .terminal import echo as echo
from .terminal import plain as plain
from .terminal import print_table as print_table
from .terminal import reported as reported
from .terminal import to_json as to_json
