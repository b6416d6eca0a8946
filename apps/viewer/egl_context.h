// An OpenGL 3.3 context that needs no display: EGL without a surface.
#pragma once

#include "proxima/result.h"

namespace proxima {

/// Owns the context. To be used by the thread that made it current last.
class EglContext {
public:
    /// Error unsupported_format where the machine has no EGL, no surfaceless platform or no OpenGL
    /// 3.3.
    [[nodiscard]] static Result<EglContext> create();

    EglContext(EglContext&& other) noexcept;
    EglContext& operator=(EglContext&&) = delete;
    EglContext(const EglContext&) = delete;
    EglContext& operator=(const EglContext&) = delete;
    ~EglContext();

    [[nodiscard]] Status make_current() const;

private:
    EglContext(void* display, void* context) noexcept : display_(display), context_(context) {}

    void* display_;
    void* context_;
};

} // namespace proxima
