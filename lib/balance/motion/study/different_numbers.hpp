#pragma once
/// Whether numbers with sizes can have different sizes.

#include "balance/motion/study/study.hpp"

#include <string>
#include <vector>

namespace balance::study {

/// Whether two sizes are equal up to round-off. @param scale largest magnitude of such sizes
bool is_same_size(double a, double b, double scale);

/// Whether one of the sizes that are taken is this one.
bool is_taken(const std::vector<double>& taken, double size, double scale);

/// The different sizes of all domains, ascending.
std::vector<double> merge_sizes(const std::vector<std::vector<double>>& domains, double scale);

/// Indices of the free numbers with these paths.
std::vector<int> find_free_numbers(const std::vector<std::string>& paths, const std::vector<FreeNumber>& free);

/// Domains that together have fewer different sizes than there are of them (Hall's theorem); empty if each domain can
/// give a size of its own.
/// @param domains sizes from which one is to be taken each @param scale as in is_same_size
std::vector<std::size_t> find_scarce_domains(const std::vector<std::vector<double>>& domains, double scale);

/// Why the numbers cannot all be different: "a, b and c have only 2 different sizes: 0 and 90"; empty if they can.
/// @param free in which the numbers are indices
std::string find_size_shortage(const DifferentNumbers& different, const std::vector<FreeNumber>& free);

}  // namespace balance::study
