#pragma once

// Tables of HTML documents.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace palpate {

// Builds a table row by row. The table is in a separate box, which scrolls if the table is wider
// than the box. The first columns hold text and verdicts, the others numbers.
class HtmlTable {
 public:
  // heads: plain text; this class escapes it.
  // groups: titles above the heads, and the number of columns of each.
  explicit HtmlTable(const std::vector<std::string>& heads, std::size_t text_columns = 1,
                     const std::vector<std::pair<std::string, std::size_t>>& groups = {});

  // Cells are HTML.
  void row(const std::vector<std::string>& cells);
  // A row with one text (HTML) that introduces the rows below it.
  void heading(const std::string& text);
  std::string html() const { return html_ + "</tbody></table></div>\n"; }

 private:
  void cell(const char* tag, std::size_t column, const std::string& content);

  std::size_t columns_;
  std::size_t text_columns_;
  std::string html_;
};

}  // namespace palpate
