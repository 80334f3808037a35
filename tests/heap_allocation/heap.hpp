#pragma once
/// Counts what the program asks of the heap, by malloc itself: Eigen does not go through operator new.

namespace heap {

/// Requests since the program began.
long requests();

/// Whether they are counted here (not where a sanitizer owns malloc).
bool counted();

}  // namespace heap
