#pragma once

#include <tl/expected.hpp>
#include <utility>

/// Returns the error of a Result from the enclosing function if it holds one. The argument, a call
/// or a variable, is evaluated once. The error of a variable is copied, because its owner may still
/// use it. This is a macro because a function cannot return from its caller.
#define DIAPHANE_TRY(result)                                                           \
  do {                                                                                 \
    if (auto&& diaphane_try_result_ = (result); !diaphane_try_result_)                 \
      return tl::unexpected(                                                           \
          std::forward<decltype(diaphane_try_result_)>(diaphane_try_result_).error()); \
  } while (false)
