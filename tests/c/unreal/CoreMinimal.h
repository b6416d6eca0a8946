// Stand-ins for the few types of Unreal Engine that examples/unreal/ProximaIndex.h uses, so that it can be compiled.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

// NOLINTBEGIN(readability-identifier-naming): Unreal's names
using int32 = std::int32_t;
using uint32 = std::uint32_t;

#define UTF8_TO_TCHAR(text) text

struct FVector {
    double X = 0, Y = 0, Z = 0;
    FVector() = default;
    FVector(double x, double y, double z) : X(x), Y(y), Z(z) {}
};

template <class T>
class TArray {
public:
    TArray() = default;
    TArray(std::initializer_list<T> values) : values_(values) {}
    [[nodiscard]] const T* GetData() const { return values_.data(); }
    [[nodiscard]] int32 Num() const { return static_cast<int32>(values_.size()); }

private:
    std::vector<T> values_;
};

class FString {
public:
    FString() = default;
    explicit FString(const char* text) : text_(text) {}
    [[nodiscard]] bool IsEmpty() const { return text_.empty(); }

private:
    std::string text_;
};
// NOLINTEND(readability-identifier-naming)
