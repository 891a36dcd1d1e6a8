#pragma once

// The texts of the JSON files that ship with the program. CMake embeds them in the library.

#include <string_view>

namespace palpate {

std::string_view shipped_literature();  // literature.json
std::string_view shipped_people2005();  // people2005.json
std::string_view shipped_canonical();   // canonical.json
std::string_view shipped_paper();       // paper.json: its objects are file names without a folder
std::string_view shipped_paper_live();  // paper_live.json: as well
std::string_view shipped_paper_live_mouse();  // paper_live_mouse.json: as well
std::string_view shipped_sweep();             // sweep.json: as well

}  // namespace palpate
