from contactlab.studies.function import function_of as function_of
from contactlab.studies.study import (
    Part as Part,
    Result as Result,
    Study as Study,
    Task as Task,
    estimates as estimates,
    option as option,
)
from contactlab.studies.tables import table as table, table_of_quantities as table_of_quantities
