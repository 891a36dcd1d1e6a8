// Writes the TypeScript that decodes a record, from the record's table.
//
// usage: make_record_decoder FILE

#include <cstdio>
#include <fstream>
#include <span>
#include <string>
#include <string_view>

#include "palpate/record.h"

namespace palpate {
namespace {

std::string getter(FieldType type, std::size_t offset) {
  const std::string at = "at + " + std::to_string(offset);
  switch (type) {
    case FieldType::kUint64:
      return "Number(view.getBigUint64(" + at + ", true))";
    case FieldType::kInt64:
      return "Number(view.getBigInt64(" + at + ", true))";
    case FieldType::kDouble:
      return "view.getFloat64(" + at + ", true)";
    case FieldType::kUint32:
      return "view.getUint32(" + at + ", true)";
    case FieldType::kUint16:
      return "view.getUint16(" + at + ", true)";
    case FieldType::kInt32:
      return "view.getInt32(" + at + ", true)";
  }
  return "";
}

std::string repeated(const RecordField& field, const auto& part) {
  if (field.count == 1) return part(0);
  std::string list = "[";
  for (std::size_t i = 0; i < field.count; ++i) list += (i > 0 ? ", " : "") + part(i);
  return list + "]";
}

std::string interface_text() {
  std::string text = "export interface TickRecord {\n";
  for (const RecordField& field : kRecordFields) {
    text += "  /** unit: " + std::string(field.unit) +
            (field.frame.empty() ? "" : "; frame: " + std::string(field.frame)) + " */\n";
    text += "  " + std::string(field.name) + ": " +
            repeated(field, [](std::size_t) { return std::string("number"); }) + ";\n";
  }
  return text + "}\n";
}

std::string decoder_text() {
  std::string text =
      "/** Decodes the record that begins at this byte. Whole numbers are exact up to 2^53. */\n"
      "export function decodeRecord(view: DataView, at: number): TickRecord {\n  return {\n";
  for (const RecordField& field : kRecordFields) {
    const std::size_t size = field.bytes / field.count;
    text += "    " + std::string(field.name) + ": " +
            repeated(field,
                     [&](std::size_t i) { return getter(field.type, field.offset + i * size); }) +
            ",\n";
  }
  return text + "  };\n}\n";
}

// An array of the names of bits, from the lowest bit on.
std::string names_text(const std::string& comment, const std::string& name,
                       std::span<const std::string_view> names) {
  std::string text = "/** " + comment + " */\nexport const " + name + ": readonly string[] = [";
  for (std::size_t bit = 0; bit < names.size(); ++bit) {
    text += (bit > 0 ? ", \"" : "\"") + std::string(names[bit]) + "\"";
  }
  return text + "];\n";
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: make_record_decoder FILE\n", stderr);
    return 2;
  }
  std::ofstream file(argv[1]);
  file << "// Made by make_record_decoder from kRecordFields (palpate/record.h).\n\n"
       << "export const recordBytes = " << sizeof(palpate::TickRecord) << ";\n\n"
       << palpate::interface_text() << "\n"
       << palpate::decoder_text() << "\n"
       << palpate::names_text("The names of the bits of faults, from the lowest bit on.",
                              "faultNames", palpate::kFaultNames)
       << palpate::names_text("The names of the bits of rules, from the lowest bit on.",
                              "ruleNames", palpate::kGovernorRuleNames);
  file.flush();
  if (!file) std::fprintf(stderr, "make_record_decoder: cannot write %s\n", argv[1]);
  return file ? 0 : 1;
}
