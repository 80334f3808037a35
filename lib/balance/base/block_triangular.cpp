#include "balance/base/block_triangular.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

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
      : pattern_(pattern),
        matching_(matching),
        index_(pattern.rows(), -1),
        low_(pattern.rows()),
        open_(pattern.rows()) {}

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

/// In place, with row exchanges; the diagonal holds the pivots' reciprocals. N is the size where it is known when compiling:
/// the blocks of most mechanisms are so small that loops would cost more than the arithmetic.
/// Returns the smallest pivot and flips `sign` with every exchange and every negative pivot.
template <int N>
double factorise_block(double* a, int* pivots, int size, int& sign) {
  const int n = N > 0 ? N : size;
  double smallest = INFINITY;
  for (int k = 0; k < n; ++k) {
    int best = k;
    double largest = std::abs(a[k * n + k]);
    for (int i = k + 1; i < n; ++i)
      if (std::abs(a[i * n + k]) > largest) largest = std::abs(a[i * n + k]), best = i;
    pivots[k] = best;
    if (best != k) {
      for (int j = 0; j < n; ++j) std::swap(a[k * n + j], a[best * n + j]);
      sign = -sign;
    }
    smallest = std::min(smallest, largest);
    if (!(largest > 0)) return 0;
    const double inverse = 1 / a[k * n + k];
    if (inverse < 0) sign = -sign;
    a[k * n + k] = inverse;
    for (int i = k + 1; i < n; ++i) {
      const double factor = a[i * n + k] *= inverse;
      for (int j = k + 1; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
    }
  }
  return smallest;
}

// x −= a y and x *= a, for numbers and for pairs of them.
void subtract(double& x, double a, double y) { x -= a * y; }
void scale(double& x, double a) { x *= a; }
template <class Pair>
void subtract(Pair& x, double a, const Pair& y) {
  x.x -= a * y.x;
  x.z -= a * y.z;
}
template <class Pair>
void scale(Pair& x, double a) {
  x.x *= a;
  x.z *= a;
}

/// The unknowns of a small block live in registers. X: a number or a pair of them.
template <int N, class X>
struct Local {
  X values[N];
  explicit Local(const X* x) {
    for (int i = 0; i < N; ++i) values[i] = x[i];
  }
  void store(X* x) const {
    for (int i = 0; i < N; ++i) x[i] = values[i];
  }
  X& operator[](int i) { return values[i]; }
};
template <class X>
struct Local<0, X> {
  X* x;
  explicit Local(X* values) : x(values) {}
  void store(X*) const {}
  X& operator[](int i) { return x[i]; }
};

template <int N, class X>
void solve_block(const double* a, const int* pivots, int size, X* x) {
  const int n = N > 0 ? N : size;
  for (int k = 0; k < n; ++k)
    if (pivots[k] != k) std::swap(x[k], x[pivots[k]]);
  Local<N, X> v(x);
  for (int i = 1; i < n; ++i)
    for (int j = 0; j < i; ++j) subtract(v[i], a[i * n + j], v[j]);
  for (int i = n - 1; i >= 0; --i) {
    for (int j = i + 1; j < n; ++j) subtract(v[i], a[i * n + j], v[j]);
    scale(v[i], a[i * n + i]);
  }
  v.store(x);
}

template <int N>
void solve_block_transposed(const double* a, const int* pivots, int size, double* x) {
  const int n = N > 0 ? N : size;
  Local<N, double> v(x);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) v[i] -= a[j * n + i] * v[j];
    v[i] *= a[i * n + i];
  }
  for (int i = n - 1; i >= 0; --i)
    for (int j = i + 1; j < n; ++j) v[i] -= a[j * n + i] * v[j];
  v.store(x);
  for (int k = n - 1; k >= 0; --k)
    if (pivots[k] != k) std::swap(x[k], x[pivots[k]]);
}

/// Largest block that is inverted by cofactors: one division instead of a chain of them, and products that need not wait for
/// each other.
constexpr int inverted = 3;

/// 1/largest entry of the inverse: no larger than the smallest singular value times the size. 0 if singular.
double accept_inverse(double* inverse, int entries, double determinant, int& sign) {
  if (!(std::abs(determinant) > 0)) return 0;
  if (determinant < 0) sign = -sign;
  const double scale = 1 / determinant;
  double largest = 0;
  for (int i = 0; i < entries; ++i) {
    inverse[i] *= scale;
    largest = std::max(largest, std::abs(inverse[i]));
  }
  return 1 / largest;
}

double invert(std::integral_constant<int, 1>, double* a, int& sign) {
  const double determinant = a[0];
  a[0] = 1;
  return accept_inverse(a, 1, determinant, sign);
}

double invert(std::integral_constant<int, 2>, double* a, int& sign) {
  const double determinant = a[0] * a[3] - a[1] * a[2];
  std::swap(a[0], a[3]);
  a[1] = -a[1];
  a[2] = -a[2];
  return accept_inverse(a, 4, determinant, sign);
}

double invert(std::integral_constant<int, 3>, double* a, int& sign) {
  const double c[9] = {a[4] * a[8] - a[5] * a[7], a[2] * a[7] - a[1] * a[8], a[1] * a[5] - a[2] * a[4],
                       a[5] * a[6] - a[3] * a[8], a[0] * a[8] - a[2] * a[6], a[2] * a[3] - a[0] * a[5],
                       a[3] * a[7] - a[4] * a[6], a[1] * a[6] - a[0] * a[7], a[0] * a[4] - a[1] * a[3]};
  const double determinant = a[0] * c[0] + a[1] * c[3] + a[2] * c[6];
  std::copy_n(c, 9, a);
  return accept_inverse(a, 9, determinant, sign);
}

template <int N, class X>
void multiply(const double* inverse, X* x) {
  const Local<N, X> v(x);
  for (int i = 0; i < N; ++i) {
    X sum = v.values[0];
    scale(sum, inverse[i * N]);
    for (int j = 1; j < N; ++j) subtract(sum, -inverse[i * N + j], v.values[j]);
    x[i] = sum;
  }
}

template <int N>
void multiply_transposed(const double* inverse, double* x) {
  const Local<N, double> v(x);
  for (int i = 0; i < N; ++i) {
    double sum = 0;
    for (int j = 0; j < N; ++j) sum += inverse[j * N + i] * v.values[j];
    x[i] = sum;
  }
}

/// Calls `work` with the size as a compile-time constant where it is small, else 0.
template <class Work>
auto by_size(int n, const Work& work) {
  switch (n) {
    case 1: return work(std::integral_constant<int, 1>{});
    case 2: return work(std::integral_constant<int, 2>{});
    case 3: return work(std::integral_constant<int, 3>{});
    case 4: return work(std::integral_constant<int, 4>{});
    case 5: return work(std::integral_constant<int, 5>{});
    case 6: return work(std::integral_constant<int, 6>{});
    default: return work(std::integral_constant<int, 0>{});
  }
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
  pairs_.assign(n, {0, 0});
  return true;
}

double BlockTriangular::factorise() {
  const int n = size();
  double quality = 1;
  sign_ = 1;
  for (const Block& block : blocks_) {
    double* factors = factors_.data() + block.offset;
    for (int i = 0; i < block.size; ++i) {
      const double* row = &values_[(block.begin + i) * n + block.begin];
      for (int j = 0; j < block.size; ++j) factors[i * block.size + j] = row[j];
    }
    const double smallest = by_size(block.size, [&](auto block_size) {
      if constexpr (block_size > 0 && block_size <= inverted)
        return invert(block_size, factors, sign_);
      else
        return factorise_block<block_size>(factors, &pivots_[block.begin], block.size, sign_);
    });
    quality = std::min(quality, smallest);
    if (quality == 0) return 0;
  }
  return quality;
}

template <class X>
void BlockTriangular::substitute(X* work) const {
  const int n = size();
  for (const Block& block : blocks_) {
    for (int i = block.begin; i < block.begin + block.size; ++i) {
      const double* values = &values_[i * n];
      X sum = work[i];
      for (int j = first_[i]; j < block.begin; ++j) subtract(sum, values[j], work[j]);
      work[i] = sum;
    }
    by_size(block.size, [&](auto block_size) {
      const double* factors = factors_.data() + block.offset;
      if constexpr (block_size > 0 && block_size <= inverted)
        multiply<block_size>(factors, work + block.begin);
      else
        solve_block<block_size>(factors, &pivots_[block.begin], block.size, work + block.begin);
    });
  }
}

void BlockTriangular::solve(double* x) {
  const int n = size();
  for (int row = 0; row < n; ++row) work_[row_position_[row]] = x[row];
  substitute(work_.data());
  for (int column = 0; column < n; ++column) x[column] = work_[column_position_[column]];
}

void BlockTriangular::solve_pair(double* x, double* z) {
  const int n = size();
  for (int row = 0; row < n; ++row) pairs_[row_position_[row]] = {x[row], z[row]};
  substitute(pairs_.data());
  for (int column = 0; column < n; ++column) {
    const Pair& pair = pairs_[column_position_[column]];
    x[column] = pair.x;
    z[column] = pair.z;
  }
}

void BlockTriangular::solve_transposed(double* x) {
  const int n = size();
  for (int column = 0; column < n; ++column) work_[column_position_[column]] = x[column];
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {
    by_size(block->size, [&](auto block_size) {
      const double* factors = factors_.data() + block->offset;
      if constexpr (block_size > 0 && block_size <= inverted)
        multiply_transposed<block_size>(factors, &work_[block->begin]);
      else
        solve_block_transposed<block_size>(factors, &pivots_[block->begin], block->size, &work_[block->begin]);
    });
    for (int i = block->begin; i < block->begin + block->size; ++i) {
      const double* values = &values_[i * n];
      for (int j = first_[i]; j < block->begin; ++j) work_[j] -= values[j] * work_[i];
    }
  }
  for (int row = 0; row < n; ++row) x[row] = work_[row_position_[row]];
}

}  // namespace balance
