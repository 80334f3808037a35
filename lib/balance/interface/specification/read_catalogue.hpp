#pragma once
/// Elements whose numbers are those of a row of a catalogue: `catalogue: springs.csv, columns: {stiffness: rate}`.

#include "balance/interface/specification/study_builder.hpp"

#include <optional>
#include <string>
#include <vector>

namespace balance::specification {

/// A number that a row may give to an element.
struct CatalogueProperty {
  std::string name;  ///< as the element's own key
  Dimension dimension;
  SignConstraint sign = SignConstraint::not_negative;
};

/// The places of the keys in the spec.
struct CatalogueKeys {
  std::optional<SpecCursor> catalogue, columns, count;

  /// Fields for read_fields().
  std::vector<Field> fields();
};

/// The numbers of one part of the chosen row.
class CatalogueNumbers {
 public:
  /// @return the expression; nullopt if the catalogue does not determine it
  std::optional<Expression> find(const std::string& property) const {
    for (const auto& [name, value] : numbers_)
      if (name == property) return value;
    return std::nullopt;
  }
  const std::vector<std::pair<std::string, Expression>>& all() const { return numbers_; }

  Expression count = 1;  ///< parts side by side

 private:
  friend CatalogueNumbers read_catalogue(const std::string& path, const CatalogueKeys& keys, StudyBuilder& draft,
                                         const std::vector<CatalogueProperty>& properties);
  std::vector<std::pair<std::string, Expression>> numbers_;
};

/// Reads the file and adds the choice to the study. Its rows are free unless the spec names a part.
/// @param path of the element: "springs.s"
/// @param keys with a catalogue
CatalogueNumbers read_catalogue(const std::string& path, const CatalogueKeys& keys, StudyBuilder& draft,
                                const std::vector<CatalogueProperty>& properties);

/// The number of a key or of the catalogue. Fails if both give it.
/// @param at the element
/// @param catalogue null: the element is not of a catalogue
/// @param key null: the spec does not state it
std::optional<Expression> choose_number(const CatalogueNumbers* catalogue, const std::string& name,
                                        const SpecCursor* key, StudyBuilder& draft, Dimension dimension,
                                        SignConstraint sign);

// The text of a catalogue.

/// A field of a table of text.
struct TextRow {
  long line = 0;  ///< from 1
  std::vector<std::string> fields;
};

/// Rows of comma-separated text with optional double quotes; lines that begin with `#` are comments. The first row has
/// the names of the columns.
/// @throws std::runtime_error with the line, for a row with another number of fields, or a quote without an end
std::vector<TextRow> parse_text_table(const std::string& text);

}  // namespace balance::specification
