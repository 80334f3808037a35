#pragma once
/// The free numbers of a spec while it is being read, and values to read it with again.

#include "balance/base/types.hpp"
#include "balance/spec/node.hpp"
#include "balance/study/study.hpp"

#include <string>
#include <unordered_map>
#include <vector>

namespace balance::read {

/// A free number and the mapping that says so. Its span is not known yet.
struct FoundFreeNumber {
  const Node* node = nullptr;
  FreeNumber number;
};

/// Values of expressions.
using Calculated = std::unordered_map<std::string, double>;

/// Values of all free numbers by their key path, as FreeNumber::start is, and of the expressions that they do not change.
class FreeValues {
 public:
  using Index = std::unordered_map<std::string, Eigen::Index>;

  FreeValues(const Index& index, const VectorX& x, const Calculated& constants)
      : index_(&index), x_(&x), constants_(&constants) {}
  double operator[](const std::string& path) const { return (*x_)[index_->at(path)]; }
  const Calculated& constants() const { return *constants_; }

 private:
  const Index* index_;
  const VectorX* x_;
  const Calculated* constants_;
};

}  // namespace balance::read
