#include "engine/report/html_table.h"

#include "engine/report/html.h"

namespace palpate {

HtmlTable::HtmlTable(const std::vector<std::string>& heads, std::size_t text_columns,
                     const std::vector<std::pair<std::string, std::size_t>>& groups)
    : columns_(heads.size()), text_columns_(text_columns) {
  html_ = "<div class=\"wide\"><table><thead>";
  if (!groups.empty()) html_ += "<tr class=\"groups\">";
  for (const auto& [title, columns] : groups) {
    html_ += html_element("th colspan=\"" + std::to_string(columns) + "\"", html_escaped(title));
  }
  html_ += groups.empty() ? "<tr>" : "</tr><tr>";
  for (std::size_t i = 0; i < heads.size(); ++i) cell("th", i, html_escaped(heads[i]));
  html_ += "</tr></thead><tbody>\n";
}

void HtmlTable::row(const std::vector<std::string>& cells) {
  html_ += "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) cell("td", i, cells[i]);
  html_ += "</tr>\n";
}

// The text spans the columns of text alone, so that it fits a narrow screen.
void HtmlTable::heading(const std::string& text) {
  const std::size_t rest = columns_ - text_columns_;
  html_ += "<tr class=\"method\"><th colspan=\"" + std::to_string(text_columns_) + "\">" + text +
           "</th>";
  if (rest > 0) html_ += "<th colspan=\"" + std::to_string(rest) + "\"></th>";
  html_ += "</tr>\n";
}

void HtmlTable::cell(const char* tag, std::size_t column, const std::string& content) {
  html_ += html_element(
      std::string(tag) + (column < text_columns_ ? " class=\"verdict\"" : " class=\"number\""),
      content);
}

}  // namespace palpate
