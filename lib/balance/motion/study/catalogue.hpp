#pragma once
/// Parts that are bought: elements of a mechanism whose numbers are those of a row of a catalogue.

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace balance::study {

/// A number of an element that the row determines.
struct CatalogueColumn {
  std::string name;            ///< as a key of the element: "stiffness"
  std::string unit;            ///< SI
  std::vector<double> values;  ///< of one part, per row [SI]
  int input = -1;              ///< in the study's recording; −1: the row is given
};

/// A file with one part per row, as it was read.
struct CatalogueFile {
  std::string name;  ///< as in the spec, relative to its folder
  std::string text;
};

/// An element that is some number of equal parts, which act side by side.
struct CatalogueChoice {
  std::string path;  ///< of the element: "springs.s"
  std::shared_ptr<const CatalogueFile> file;
  std::vector<std::string> parts;        ///< name of each row; a part with several possible counts has several rows
  std::vector<int> counts;               ///< number of parts, per row
  std::vector<CatalogueColumn> columns;  ///< numbers of the element
  std::vector<double> masses, prices;    ///< of one part, per row; empty: not in the catalogue [kg], [`currency`]
  std::string currency;                  ///< "EUR"; may be empty
  int row = 0;                           ///< chosen, or with which the spec is read if it is free
  bool is_free = false;                  ///< whether a design chooses the row
  std::size_t begin = 0, end = 0;        ///< bytes of spec_text for the value of `catalogue`

  int rows() const { return static_cast<int>(parts.size()); }
  /// Values of a column; null if the catalogue lacks it.
  const std::vector<double>* find_column(const std::string& name) const {
    for (const CatalogueColumn& column : columns)
      if (column.name == name) return &column.values;
    return nullptr;
  }
  /// Mass of all parts of a row [kg]; 0 if the catalogue has none.
  double mass_of(int r) const { return total(masses, r); }
  /// Price of all parts of a row; 0 if the catalogue has none.
  double price_of(int r) const { return total(prices, r); }

 private:
  double total(const std::vector<double>& values, int r) const {
    const auto k = static_cast<std::size_t>(r);
    return values.empty() ? 0 : counts[k] * values[k];
  }
};

}  // namespace balance::study
