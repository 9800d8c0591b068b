"""Numbers of a law, a drive or an error from measurements: fits, scans of orders, intervals, what a model lacks."""

from .files.fields.csv_files import read_profile as read_profile
from .files.logs.scan_file import read_scan as read_scan
from .files.variants.identify_log import identify_log as identify_log
from .study.gear.hysteresis_loop import fit_hysteresis as fit_hysteresis
from .study.identification.arrangement import arrangement as arrangement
from .study.identification.bode.bode_fit import fit_bode as fit_bode
from .study.identification.bode.measured_bode import bode_of_records as bode_of_records
from .study.identification.bode.measured_bode import measured_bode as measured_bode
from .study.identification.discrepancy import discrepancy as discrepancy
from .study.identification.fitted import unidentifiable as unidentifiable
from .study.identification.identify import identify as identify
from .study.identification.intervals import bootstrap as bootstrap
from .study.identification.intervals import sandwich as sandwich
from .study.identification.intervals import spread as spread
from .study.identification.law_fit import compare_laws as compare_laws
from .study.identification.loops.loop_fit import fit_loop as fit_loop
from .study.identification.orders.error_scan import error_scan as error_scan
from .study.identification.orders.order_scan import order_scan as order_scan

__all__: list[str]
