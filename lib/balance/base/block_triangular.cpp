#include "balance/base/block_triangular.hpp"

#include <algorithm>
#include <cmath>

namespace balance {

namespace {

/// Augmenting paths: a column for every row.
class Matching {
 public:
  explicit Matching(const Eigen::MatrixXi& pattern)
      : pattern_(pattern), column_of(pattern.rows(), -1), row_of(pattern.cols(), -1) {}

  bool run() {
    for (int row = 0; row < pattern_.rows(); ++row) {
      std::vector<bool> seen(pattern_.cols(), false);
      if (!augment(row, seen)) return false;
    }
    return true;
  }

 private:
  bool augment(int row, std::vector<bool>& seen) {
    for (int column = 0; column < pattern_.cols(); ++column) {
      if (!pattern_(row, column) || seen[column]) continue;
      seen[column] = true;
      if (row_of[column] >= 0 && !augment(row_of[column], seen)) continue;
      row_of[column] = row;
      column_of[row] = column;
      return true;
    }
    return false;
  }

  const Eigen::MatrixXi& pattern_;

 public:
  std::vector<int> column_of, row_of;
};

/// Tarjan's strongly connected components of the graph row → row matched to a column that the row needs; they come out in the
/// order in which they must be solved.
class Components {
 public:
  Components(const Eigen::MatrixXi& pattern, const Matching& matching)
      : pattern_(pattern), matching_(matching), index_(pattern.rows(), -1), low_(pattern.rows()), open_(pattern.rows()) {}

  std::vector<std::vector<int>> run() {
    for (int row = 0; row < pattern_.rows(); ++row)
      if (index_[row] < 0) visit(row);
    return components_;
  }

 private:
  void visit(int row) {
    index_[row] = low_[row] = counter_++;
    stack_.push_back(row);
    open_[row] = true;
    for (int column = 0; column < pattern_.cols(); ++column) {
      if (!pattern_(row, column)) continue;
      const int next = matching_.row_of[column];
      if (index_[next] < 0) {
        visit(next);
        low_[row] = std::min(low_[row], low_[next]);
      } else if (open_[next]) {
        low_[row] = std::min(low_[row], index_[next]);
      }
    }
    if (low_[row] != index_[row]) return;
    std::vector<int> component;
    int member;
    do {
      member = stack_.back();
      stack_.pop_back();
      open_[member] = false;
      component.push_back(member);
    } while (member != row);
    std::sort(component.begin(), component.end());
    components_.push_back(component);
  }

  const Eigen::MatrixXi& pattern_;
  const Matching& matching_;
  std::vector<int> index_, low_;
  std::vector<bool> open_;
  std::vector<int> stack_;
  std::vector<std::vector<int>> components_;
  int counter_ = 0;
};

/// In place, with row exchanges; returns the smallest pivot relative to its row's largest original entry and flips `sign`.
double factorise_block(double* a, int* pivots, int n, int& sign) {
  double quality = 1;
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i)
      if (std::abs(a[i * n + k]) > std::abs(a[best * n + k])) best = i;
    pivots[k] = best;
    if (best != k) {
      std::swap_ranges(a + k * n, a + (k + 1) * n, a + best * n);
      sign = -sign;
    }
    const double pivot = a[k * n + k];
    quality = std::min(quality, std::abs(pivot));
    if (pivot == 0) return 0;
    if (pivot < 0) sign = -sign;
    const double inverse = 1 / pivot;
    for (int i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] *= inverse;
      for (int j = k + 1; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
    }
  }
  return quality;
}

void solve_block(const double* a, const int* pivots, int n, double* x) {
  for (int k = 0; k < n; ++k)
    if (pivots[k] != k) std::swap(x[k], x[pivots[k]]);
  for (int i = 1; i < n; ++i) {
    double sum = x[i];
    for (int j = 0; j < i; ++j) sum -= a[i * n + j] * x[j];
    x[i] = sum;
  }
  for (int i = n - 1; i >= 0; --i) {
    double sum = x[i];
    for (int j = i + 1; j < n; ++j) sum -= a[i * n + j] * x[j];
    x[i] = sum / a[i * n + i];
  }
}

void solve_block_transposed(const double* a, const int* pivots, int n, double* x) {
  for (int i = 0; i < n; ++i) {
    double sum = x[i];
    for (int j = 0; j < i; ++j) sum -= a[j * n + i] * x[j];
    x[i] = sum / a[i * n + i];
  }
  for (int i = n - 1; i >= 0; --i) {
    double sum = x[i];
    for (int j = i + 1; j < n; ++j) sum -= a[j * n + i] * x[j];
    x[i] = sum;
  }
  for (int k = n - 1; k >= 0; --k)
    if (pivots[k] != k) std::swap(x[k], x[pivots[k]]);
}

}  // namespace

bool BlockTriangular::analyse(const Eigen::MatrixXi& pattern) {
  const int n = static_cast<int>(pattern.rows());
  row_position_.assign(n, 0);
  column_position_.assign(n, 0);
  blocks_.clear();
  Matching matching(pattern);
  if (!matching.run()) return false;
  int position = 0, offset = 0;
  for (const std::vector<int>& component : Components(pattern, matching).run()) {
    const int size = static_cast<int>(component.size());
    blocks_.push_back({position, size, offset});
    offset += size * size;
    for (const int row : component) {
      row_position_[row] = position;
      column_position_[matching.column_of[row]] = position++;
    }
  }
  first_.assign(n, n);
  for (int row = 0; row < n; ++row)
    for (int column = 0; column < n; ++column)
      if (pattern(row, column))
        first_[row_position_[row]] = std::min(first_[row_position_[row]], column_position_[column]);
  values_.assign(static_cast<std::size_t>(n) * n, 0);
  factors_.assign(offset, 0);
  pivots_.assign(n, 0);
  work_.assign(n, 0);
  return true;
}

double BlockTriangular::factorise() {
  const int n = size();
  double quality = 1;
  sign_ = 1;
  for (const Block& block : blocks_) {
    double* factors = factors_.data() + block.offset;
    for (int i = 0; i < block.size; ++i)
      std::copy_n(&values_[(block.begin + i) * n + block.begin], block.size, factors + i * block.size);
    quality = std::min(quality, factorise_block(factors, &pivots_[block.begin], block.size, sign_));
    if (quality == 0) return 0;
  }
  return quality;
}

void BlockTriangular::solve(double* x) {
  const int n = size();
  for (int row = 0; row < n; ++row) work_[row_position_[row]] = x[row];
  for (const Block& block : blocks_) {
    for (int i = block.begin; i < block.begin + block.size; ++i) {
      const double* values = &values_[i * n];
      double sum = work_[i];
      for (int j = first_[i]; j < block.begin; ++j) sum -= values[j] * work_[j];
      work_[i] = sum;
    }
    solve_block(factors_.data() + block.offset, &pivots_[block.begin], block.size, &work_[block.begin]);
  }
  for (int column = 0; column < n; ++column) x[column] = work_[column_position_[column]];
}

void BlockTriangular::solve_transposed(double* x) {
  const int n = size();
  for (int column = 0; column < n; ++column) work_[column_position_[column]] = x[column];
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {
    solve_block_transposed(factors_.data() + block->offset, &pivots_[block->begin], block->size, &work_[block->begin]);
    for (int i = block->begin; i < block->begin + block->size; ++i) {
      const double* values = &values_[i * n];
      for (int j = first_[i]; j < block->begin; ++j) work_[j] -= values[j] * work_[i];
    }
  }
  for (int row = 0; row < n; ++row) x[row] = work_[row_position_[row]];
}

}  // namespace balance
