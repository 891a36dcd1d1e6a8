// The cases of the tests of broken inputs, each read by both readers.

#include "tests/engine/trials/old/compare_tables.h"

#define parse_trials tables::compared_trials
#include "tests/engine/trials/broken_inputs_test.cpp"
