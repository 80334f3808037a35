#pragma once
/// Figures of a design as functions of the rows of catalogues and of the places of springs, along motions that do not
/// depend on them, and lower bounds of these figures over sets of rows and boxes of places.

#include "balance/foundation/base/interval.hpp"
#include "balance/motion/study/design_space.hpp"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace balance::design {

/// The rows of a catalogue as a binary tree of sets of similar ones.
class RowTree {
 public:
  struct Set {
    int begin = 0, end = 0;       ///< into rows()
    int left = -1, right = -1;    ///< halves; −1: a single row, or rows that are equal in all attributes
    std::vector<Interval> range;  ///< of each attribute
  };

  RowTree() = default;
  /// @param attributes of each row, a column for each
  /// @param coordinates of each row: sets are divided where they differ most
  RowTree(const MatrixX& attributes, const MatrixX& coordinates);

  const std::vector<Set>& sets() const { return sets_; }  ///< the first one has all rows
  const std::vector<int>& rows() const { return rows_; }
  const MatrixX& attributes() const { return attributes_; }

 private:
  int build(int begin, int end);

  MatrixX attributes_, coordinates_;
  std::vector<int> rows_;
  std::vector<Set> sets_;
};

/// Sets of rows and a box of the free numbers.
struct CatalogueBox {
  std::vector<int> sets;  ///< of each choice: index into the sets of its tree
  VectorX lower, upper;   ///< of the free numbers [SI]
  double bound = 0;       ///< of the objective
};

/// A lower bound of the objective, and what nearly attains it.
struct CatalogueBound {
  bool is_feasible = true;  ///< false: no design in the box keeps the limits
  double lower = 0;
  VectorX x;                                        ///< free numbers
  std::vector<int> rows;                            ///< of each choice
  std::vector<std::array<CatalogueBox, 2>> halves;  ///< of the box; empty: it is a point
};

/// Rows and free numbers with their figures.
struct CatalogueDesign {
  std::vector<int> rows;
  VectorX x;
  double value = 0;      ///< of the objective
  double violation = 0;  ///< of the worst limit that the program knows, relative; ≤ 0: all are kept
};

class CatalogueProgram {
 public:
  /// @param space with free rows and free numbers, which may only change springs: their ends, stiffness and lengths
  /// @param terms of the objective
  /// @throws CatalogueProgramError if the figures are not such functions
  CatalogueProgram(const DesignSpace& space, const std::vector<ObjectiveTerm>& terms);
  ~CatalogueProgram();
  CatalogueProgram(CatalogueProgram&&) noexcept;

  CatalogueBox root() const;
  /// Every design in the box within the limits has at least this objective or that of the cutoff.
  /// @param cutoff of the objective: designs beyond it do not matter; may be infinite
  CatalogueBound bound(const CatalogueBox& box, double cutoff) const;
  /// Descends from there with its rows.
  CatalogueDesign improve(const CatalogueDesign& start) const;
  CatalogueDesign evaluate(const std::vector<int>& rows, const VectorX& x) const;
  /// The rows of a choice in an order in which neighbours are similar.
  const std::vector<int>& similar_rows(int choice) const;
  /// Whether all limits of the design are known to the program.
  bool knows_all_limits() const;

 private:
  struct Implementation;
  std::unique_ptr<const Implementation> implementation_;
};

/// Why there is no such program, as a clause.
class CatalogueProgramError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace balance::design
