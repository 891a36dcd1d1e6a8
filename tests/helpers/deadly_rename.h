#pragma once

// Kills a process between two renames. Files of results become visible by rename(), so that these
// are the instants at which a kill can leave different files. A program that is linked with
// deadly_rename.cpp uses its rename() in place of the one of the C library.

namespace palpate::test {

// From now on, the process kills itself (SIGKILL) in place of its count-th rename. count: at least
// 1. Renames before it work, and so do all renames without a call of this function.
void die_at_rename(int count);

}  // namespace palpate::test
