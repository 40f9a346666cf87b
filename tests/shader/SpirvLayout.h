// SPDX-License-Identifier: MIT
// Reads the layout of structs out of a SPIR-V module: member names, byte offsets and array strides.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc_tests {

struct SpirvMember {
    std::string name;
    std::uint32_t type = 0;
    std::optional<std::uint32_t> offset;
};

class SpirvLayout {
public:
    explicit SpirvLayout(std::span<const std::uint32_t> words) {
        constexpr std::uint32_t kName = 5, kMemberName = 6, kTypeArray = 28, kTypeStruct = 30, kConstant = 43;
        constexpr std::uint32_t kTypePointer = 32, kVariable = 59, kBinding = 33, kDescriptorSet = 34;
        constexpr std::uint32_t kDecorate = 71, kMemberDecorate = 72, kArrayStride = 6, kOffset = 35;
        std::size_t at = 5;
        while (at < words.size()) {
            const std::size_t count = words[at] >> 16;
            if (count == 0 || count > words.size() - at)
                return;
            const std::span<const std::uint32_t> op = words.subspan(at, count);
            switch (op[0] & 0xFFFFu) {
            case kName:
                names_[op[1]] = GetString(op.subspan(2));
                break;
            case kMemberName:
                GetMember(op[1], op[2]).name = GetString(op.subspan(3));
                break;
            case kMemberDecorate:
                if (op[3] == kOffset)
                    GetMember(op[1], op[2]).offset = op[4];
                break;
            case kDecorate:
                if (op[2] == kArrayStride)
                    strides_[op[1]] = op[3];
                else if (op[2] == kBinding)
                    bindings_[op[1]].binding = op[3];
                else if (op[2] == kDescriptorSet)
                    bindings_[op[1]].set = op[3];
                break;
            case kTypeStruct:
                for (std::size_t i = 2; i < count; ++i)
                    GetMember(op[1], static_cast<std::uint32_t>(i - 2)).type = op[i];
                break;
            case kTypePointer:
                pointers_[op[1]] = op[3];
                break;
            case kVariable:
                bindings_[op[2]].pointerType = op[1];
                bindings_[op[2]].storageClass = op[3];
                break;
            case kTypeArray:
                arrays_[op[1]] = {op[2], op[3]};
                break;
            case kConstant:
                constants_[op[2]] = op[3];
                break;
            default:
                break;
            }
            at += count;
        }
    }

    /// The struct of that name whose members have offsets (a module may hold a second one without), or null.
    const std::vector<SpirvMember>* FindStruct(const std::string& name) const {
        for (const auto& [id, members] : structs_) {
            const auto found = names_.find(id);
            if (found != names_.end() && found->second == name && !members.empty() && members[0].offset)
                return &members;
        }
        return nullptr;
    }

    /// The members of the uniform block bound there, or null.
    const std::vector<SpirvMember>* FindUniformBlock(std::uint32_t set, std::uint32_t binding) const {
        constexpr std::uint32_t kUniform = 2;
        for (const auto& [id, variable] : bindings_) {
            if (variable.storageClass != kUniform || variable.set != set || variable.binding != binding)
                continue;
            const auto pointee = pointers_.find(variable.pointerType);
            const auto found = pointee != pointers_.end() ? structs_.find(pointee->second) : structs_.end();
            if (found != structs_.end())
                return &found->second;
        }
        return nullptr;
    }

    /// The members of the block of push constants, or null.
    const std::vector<SpirvMember>* FindPushConstants() const {
        constexpr std::uint32_t kPushConstant = 9;
        for (const auto& [id, variable] : bindings_) {
            const auto pointee = pointers_.find(variable.pointerType);
            if (variable.storageClass != kPushConstant || pointee == pointers_.end())
                continue;
            const auto found = structs_.find(pointee->second);
            return found != structs_.end() ? &found->second : nullptr;
        }
        return nullptr;
    }

    /// The name of a struct's type, or nothing.
    std::string GetStructName(std::uint32_t type) const {
        const auto found = names_.find(type);
        return structs_.count(type) != 0 && found != names_.end() ? found->second : "";
    }

    /// Every scalar below a struct as "a.b[0].c" with its offset from `base`.
    void Flatten(const std::vector<SpirvMember>& members, const std::string& prefix, std::uint32_t base,
                 std::map<std::string, std::uint32_t>& fields) const {
        for (const SpirvMember& member : members)
            FlattenType(member.type, prefix + member.name, base + member.offset.value_or(0xFFFFFFFu), fields);
    }

    /// The same below any type.
    void FlattenType(std::uint32_t type, const std::string& name, std::uint32_t base,
                     std::map<std::string, std::uint32_t>& fields) const {
        if (const auto array = arrays_.find(type); array != arrays_.end()) {
            const auto stride = strides_.find(type);
            const std::uint32_t bytes = stride != strides_.end() ? stride->second : 0xFFFFFu;
            for (std::uint32_t i = 0; i < constants_.at(array->second.length); ++i)
                FlattenType(array->second.element, name + "[" + std::to_string(i) + "]", base + i * bytes,
                            fields);
        } else if (const auto found = structs_.find(type); found != structs_.end()) {
            Flatten(found->second, name.empty() ? name : name + ".", base, fields);
        } else {
            fields[name] = base;
        }
    }

private:
    struct BoundVariable {
        std::uint32_t pointerType = 0;
        std::uint32_t storageClass = ~0u;
        std::optional<std::uint32_t> set, binding;
    };
    struct ArrayType {
        std::uint32_t element, length;
    };

    static std::string GetString(std::span<const std::uint32_t> words) {
        std::string text;
        for (const std::uint32_t word : words) {
            for (int i = 0; i < 4; ++i) {
                const char c = static_cast<char>(word >> (8 * i) & 0xFFu);
                if (c == '\0')
                    return text;
                text += c;
            }
        }
        return text;
    }

    SpirvMember& GetMember(std::uint32_t id, std::uint32_t index) {
        std::vector<SpirvMember>& members = structs_[id];
        if (members.size() <= index)
            members.resize(index + 1);
        return members[index];
    }

    std::map<std::uint32_t, std::string> names_;
    std::map<std::uint32_t, std::vector<SpirvMember>> structs_;
    std::map<std::uint32_t, ArrayType> arrays_;
    std::map<std::uint32_t, std::uint32_t> strides_;
    std::map<std::uint32_t, std::uint32_t> constants_;
    std::map<std::uint32_t, std::uint32_t> pointers_; // type → what it points to
    std::map<std::uint32_t, BoundVariable> bindings_;
};

} // namespace openntc_tests
