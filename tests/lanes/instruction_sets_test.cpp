#include "../numerics/patterns.hpp"
#include "probe.hpp"

#include "balance/foundation/base/instruction_set.hpp"
#include "balance/foundation/base/pack.hpp"

#include <doctest/doctest.h>

#include <random>
#include <string>
#include <vector>

using namespace balance;

extern "C" {
extern const Probe probe_baseline;
#ifdef BALANCE_LANES_avx2
extern const Probe probe_avx2;
#endif
#ifdef BALANCE_LANES_avx512
extern const Probe probe_avx512;
#endif
}

namespace {

const Probe& probe_for(InstructionSet set) {
#ifdef BALANCE_LANES_avx2
  if (set == InstructionSet::avx2) return probe_avx2;
#endif
#ifdef BALANCE_LANES_avx512
  if (set == InstructionSet::avx512) return probe_avx512;
#endif
  REQUIRE(set == InstructionSet::baseline);
  return probe_baseline;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace

TEST_CASE("the baseline is there on every machine, with two lanes") {
  REQUIRE(!list_instruction_sets().empty());
  CHECK(list_instruction_sets().front() == InstructionSet::baseline);
  CHECK(probe_baseline.lanes == 2);
  for (const InstructionSet set : list_instruction_sets())
    MESSAGE("this machine computes with " << std::string(instruction_set_name(set)));
}

TEST_CASE("every instruction set gives the bits of the baseline: sines, sums, roots") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> mantissa(-2, 2);
  for (int round = 0; round < 2000; ++round) {
    double x[8], y[8];
    for (int l = 0; l < 8; ++l) {
      x[l] = std::ldexp(mantissa(random), static_cast<int>(random() % 40) - 20);
      y[l] = std::ldexp(mantissa(random), static_cast<int>(random() % 40) - 20);
    }
    if (round % 10 == 0) x[round % 8] = 1e200, y[round % 7] = NAN;  // lanes apart
    std::vector<double> expected(8 * Probe::operation_results);
    probe_baseline.operations(x, y, expected.data());
    for (int l = 0; l < 8; ++l) CHECK(expected[l] == sine_cosine(x[l]).sine);
    for (const InstructionSet set : list_instruction_sets()) {
      std::vector<double> found(expected.size());
      probe_for(set).operations(x, y, found.data());
      CAPTURE(std::string(instruction_set_name(set)));
      CHECK(same_bits(found, expected));
    }
  }
}

TEST_CASE("every instruction set gives the bits of the baseline: linear systems") {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> entry(-1, 1);
  for (int n = 1; n <= 9; ++n)
    for (const double apart : {0.01, 1.0}) {  // rows in an order that suits all lanes, or not
      std::vector<double> entries(static_cast<std::size_t>(8) * n * n), right(n);
      for (int i = 0; i < n * n; ++i) {
        const double middle = entry(random);
        for (int l = 0; l < 8; ++l) entries[l * n * n + i] = middle + apart * entry(random);
      }
      for (double& value : right) value = entry(random);
      numerics::BlockTriangular scalar;
      REQUIRE(scalar.analyse(places(Eigen::MatrixXi::Ones(n, n))));
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) scalar.at(i, j) = entries[i * n + j];
      REQUIRE(scalar.factorise() > 0);
      std::vector<double> expected(static_cast<std::size_t>(8) * (2 * n + 1));
      probe_baseline.solve(scalar, entries.data(), right.data(), expected.data());
      for (const InstructionSet set : list_instruction_sets()) {
        std::vector<double> found(expected.size());
        probe_for(set).solve(scalar, entries.data(), right.data(), found.data());
        CAPTURE(std::string(instruction_set_name(set)));
        CHECK(same_bits(found, expected));
      }
    }
}
