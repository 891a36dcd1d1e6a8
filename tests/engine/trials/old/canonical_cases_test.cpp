// The cases of the tests of broken inputs, each read by both readers.

#include "tests/engine/trials/old/compare_tables.h"

#define parse_canonical_rows tables::compared_canonical
#include "tests/engine/trials/canonical/canonical_plan_test.cpp"
