#pragma once
/// The numbers of a mechanism as polynomials of symbols. Private to formulas.

#include "balance/formulas/number_model.hpp"
#include "balance/formulas/polynomial.hpp"

#include <map>
#include <set>
#include <string>

namespace balance::formulas {

class SpecSymbols {
 public:
  /// @param texts what the spec says where; parameters become symbols under their names
  /// @param put_in parameters that are expressions become what these say; but for ratios
  SpecSymbols(Ring& ring, const ParametricModel& model, const SpecNumberTexts& texts, bool put_in);

  /// A number of the mechanism. What is zero whatever the parameters are is zero; what the spec makes of parameters is that; else it
  /// gets a symbol of its own.
  /// @param path in the spec: "bodies.link1.com[0]"; empty: none
  /// @param source SI
  /// @param name of the symbol if it needs one, as the field calls it: "lg1"
  Polynomial polynomial_at(const std::string& path, const Expression& source, const std::string& name, SymbolKind kind);
  Ring& ring() { return *ring_; }

 private:
  Polynomial find(const std::string& path, const Expression& source, const std::string& name, SymbolKind kind);
  Polynomial parameter(const std::string& name);
  bool read(const std::string& text, const Expression& source, SymbolKind kind, Polynomial& found);

  Ring* ring_;
  const ParametricModel* model_;
  const SpecNumberTexts* texts_;
  bool is_inlining_;
  std::map<std::string, int> symbols_;              ///< of parameters
  std::map<std::string, std::string> definitions_;  ///< of parameters that are put in: their expressions
  std::vector<double> perturbed_values_;     ///< values of parameters, by symbol, where all inputs are other numbers
  std::set<std::string> in_progress_;        ///< being read
  std::map<std::string, Polynomial> known_;  ///< by path
  friend struct ParameterFactory;
};

/// A name that formulas, C and Python can have: letters, digits and `_`; Greek letters are written out.
std::string identifier_name(const std::string& name);

}  // namespace balance::formulas
