from contactlab_data.inference.calibration import Identification as Identification, identify as identify
from contactlab_data.inference.cross_validation import ValidationError as ValidationError
from contactlab_data.measured.files import (
    read_impacts as read_impacts,
    read_measurements as read_measurements,
    write_impacts as write_impacts,
)
from contactlab_data.studies.bench.study import Bench as Bench, bench as bench
from contactlab_data.studies.fit import Fit as Fit, fit as fit
from contactlab_data.studies.synthetic import Synthetic as Synthetic
from contactlab_data.studies.validate import Validate as Validate, validate as validate
