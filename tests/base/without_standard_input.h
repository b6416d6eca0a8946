// A program that was started without a standard input: the next file that it opens gets descriptor 0.
#pragma once

#include <unistd.h>

namespace proxima {

/// Closes the standard input as long as it lives.
class WithoutStandardInput {
public:
    WithoutStandardInput() : kept_(::dup(STDIN_FILENO)) { (void)::close(STDIN_FILENO); }
    WithoutStandardInput(const WithoutStandardInput&) = delete;
    WithoutStandardInput& operator=(const WithoutStandardInput&) = delete;
    ~WithoutStandardInput()
    {
        (void)::dup2(kept_, STDIN_FILENO);
        (void)::close(kept_);
    }

private:
    int kept_;
};

} // namespace proxima
