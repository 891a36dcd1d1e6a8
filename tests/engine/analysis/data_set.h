#pragma once

// The data sets in tests/engine/analysis/data, whose README names their sources.

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/analysis/factorial_model.h"

namespace palpate::test {

class DataSet {
 public:
  explicit DataSet(const std::string& name) {
    std::ifstream file(std::string(PALPATE_EXPERIMENT_DATA) + "/" + name);
    EXPECT_TRUE(file) << name;
    std::string line;
    std::getline(file, line);
    names_ = fields_of(line);
    while (std::getline(file, line)) rows_.push_back(fields_of(line));
  }

  std::size_t size() const { return rows_.size(); }
  // The text in this row and column.
  const std::string& at(std::size_t row, const std::string& column) const {
    return rows_[row][column_place(column)];
  }
  bool is_complete(std::size_t row) const {
    return std::none_of(rows_[row].begin(), rows_[row].end(),
                        [](const std::string& field) { return field.empty(); });
  }
  double number(std::size_t row, const std::string& column) const {
    return std::stod(at(row, column));
  }
  void drop_rows(std::vector<std::size_t> rows) {
    std::sort(rows.rbegin(), rows.rend());
    for (const std::size_t row : rows) rows_.erase(rows_.begin() + static_cast<long>(row));
  }

  // A column as a factor, with its levels in the order of their first rows.
  Factor factor(const std::string& column) const {
    std::map<std::string, int> places;
    Factor factor{column, 0, {}};
    for (std::size_t row = 0; row < size(); ++row) {
      const auto [place, is_new] = places.emplace(at(row, column), factor.levels);
      if (is_new) ++factor.levels;
      factor.level_of_row.push_back(place->second);
    }
    return factor;
  }

  Eigen::MatrixXd numbers(const std::vector<std::string>& columns) const {
    Eigen::MatrixXd matrix(size(), columns.size());
    for (std::size_t row = 0; row < size(); ++row) {
      for (std::size_t c = 0; c < columns.size(); ++c) matrix(row, c) = number(row, columns[c]);
    }
    return matrix;
  }

 private:
  static std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields(1);
    for (const char c : line) {
      if (c == ',') {
        fields.emplace_back();
      } else {
        fields.back() += c;
      }
    }
    return fields;
  }
  std::size_t column_place(const std::string& column) const {
    const auto found = std::find(names_.begin(), names_.end(), column);
    EXPECT_NE(found, names_.end()) << column;
    return static_cast<std::size_t>(found - names_.begin());
  }

  std::vector<std::string> names_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace palpate::test
