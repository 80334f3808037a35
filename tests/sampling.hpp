#pragma once
/// Which part of many cases `scripts/test` tries; `scripts/soak whole` tries all of them. tests/cli/_sampling.py is the same for scripts.
///
/// The sample is drawn with the seed in the environment variable SEED, 1 unless it is set, and is printed. With BALANCE_WHOLE=1 it is the whole.

#include <doctest/doctest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numeric>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace sampling {

using Traits = std::set<std::string>;

inline bool is_whole() {
  const char* const wanted = std::getenv("BALANCE_WHOLE");
  return wanted != nullptr && std::string(wanted) == "1";
}

inline unsigned long seed() {
  const char* const wanted = std::getenv("SEED");
  return wanted != nullptr ? std::strtoul(wanted, nullptr, 10) : 1;
}

/// A generator of its own for every name.
inline std::mt19937 generator(const std::string& what) {
  const std::string text = std::to_string(seed()) + " " + what;
  std::seed_seq numbers(text.begin(), text.end());
  return std::mt19937(numbers);
}

/// What kinds of things a spec has: its sections, types of joints, drives, laws, goals, paths and forces, and whether there are loops.
inline Traits traits_of(const std::string& path) {
  static const std::set<std::string> kinds = {"space", "type", "drive", "law", "goal"};
  static const std::set<std::string> words = {"waypoints",   "circle",  "arc",     "table",   "file",  "free",
                                              "free_length", "preload", "coulomb", "viscous", "static"};
  Traits traits;
  int connections = 0, bodies = 0;
  bool moving = false;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    line.erase(std::min(line.find('#'), line.size()));
    const bool section = !line.empty() && std::isalpha(static_cast<unsigned char>(line.front())) != 0;
    if (section) traits.insert(line.substr(0, line.find(':')));
    moving = moving || line.rfind("motion:", 0) == 0;
    std::string spaced;
    for (const char c : line) spaced += std::string(":,{}[]\"'").find(c) == std::string::npos ? std::string(1, c) : " ";
    std::istringstream stream(spaced);
    const std::vector<std::string> found{std::istream_iterator<std::string>(stream), {}};
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (words.count(found[i]) != 0) traits.insert(found[i]);
      if (kinds.count(found[i]) != 0 && i + 1 < found.size()) traits.insert(found[i] + ": " + found[i + 1]);
      if (!moving) connections += found[i] == "connects", bodies += found[i] == "com";
    }
  }
  traits.insert(connections > bodies ? "closed" : "open");
  return traits;
}

/// The same for one of its trajectories: of laws and drives its own.
inline Traits traits_of(const std::string& path, int law, int drive) {
  Traits traits;
  for (const std::string& trait : traits_of(path))
    if (trait.rfind("law:", 0) != 0 && trait.rfind("drive:", 0) != 0) traits.insert(trait);
  traits.insert("law " + std::to_string(law));
  traits.insert("drive " + std::to_string(drive));
  return traits;
}

/// All cases, or a sample of at least this share of them, in their order. Every trait of any case is one of a drawn case.
/// @param what names the cases in what is printed; samples of other names are drawn independently
template <class Case, class TraitsOfCase>
std::vector<Case> draw(const std::string& what, const std::vector<Case>& cases, double share,
                       const TraitsOfCase& traits_of_case) {
  if (is_whole()) return cases;
  std::mt19937 random = generator(what);
  std::vector<std::size_t> order(cases.size());
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
  std::vector<Traits> having;
  Traits missing;
  for (const Case& one : cases) {
    having.push_back(traits_of_case(one));
    missing.insert(having.back().begin(), having.back().end());
  }
  const auto news = [&](std::size_t i) {
    return std::count_if(having[i].begin(), having[i].end(), [&](const auto& t) { return missing.count(t) != 0; });
  };
  std::set<std::size_t> drawn;
  while (!missing.empty()) {
    const std::size_t most =
        *std::max_element(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return news(a) < news(b); });
    drawn.insert(most);
    for (const std::string& trait : having[most]) missing.erase(trait);
  }
  const auto wanted = static_cast<std::size_t>(std::ceil(share * static_cast<double>(cases.size())));
  for (std::size_t k = 0; k < order.size() && drawn.size() < wanted; ++k) drawn.insert(order[k]);
  MESSAGE(what << ": " << drawn.size() << " of " << cases.size() << ", drawn with SEED=" << seed()
               << "; BALANCE_WHOLE=1 tries all");
  std::vector<Case> some;
  for (const std::size_t i : drawn) some.push_back(cases[i]);
  return some;
}

template <class Case>
std::vector<Case> draw(const std::string& what, const std::vector<Case>& cases, double share) {
  return draw(what, cases, share, [](const Case&) { return Traits(); });
}

}  // namespace sampling
