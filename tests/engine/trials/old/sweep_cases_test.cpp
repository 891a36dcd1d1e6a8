// The cases of the tests of broken inputs, each read by both readers.

#include "tests/engine/trials/old/compare_tables.h"

#define parse_sweep_rows tables::compared_sweep
#include "tests/engine/analysis/sweep_run_test.cpp"
