// SPDX-License-Identifier: MIT
// Runs Microsoft's HLSL compilers, which are DLLs, for a list of jobs: HlslWindows.exe dxcompiler.dll d3dcompiler_47.dll
// INCLUDE_DIR <jobs >answers. Built by mingw-w64, run under Wine.
// A job is a line of fields separated by tabs: dxc or fxc, source, profile, output, then definitions NAME=VALUE; fields that
// begin with - are options of DXC. An answer is a line: "ok", or "error" and the compiler's first message, behind a tab.
// Beside the output, with .txt behind its name, goes a listing of the DXIL or DXBC.
#include <windows.h>

#include <d3dcompiler.h>

#include <cstdint>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace {

std::string ReadFileText(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

bool WriteFileBytes(const std::string& path, const void* data, std::size_t size) {
    std::ofstream file(path, std::ios::binary);
    file.write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
    return file.good();
}

std::string GetFolder(const std::string& path) {
    const std::size_t slash = path.find_last_of("/\\");
    return slash == std::string::npos ? "." : path.substr(0, slash);
}

std::wstring Widen(const std::string& text) {
    return {text.begin(), text.end()};
}

// ------------------------------------------------------------------------------------------------ DXC (dxcapi.h)
constexpr GUID kClsidCompiler = {
    0x73e22d93, 0xe6ce, 0x47f3, {0xb5, 0xbf, 0xf0, 0x66, 0x4f, 0x39, 0xc1, 0xb0}};
constexpr GUID kClsidUtils = {0x6245d6af, 0x66e0, 0x48fd, {0x80, 0xb4, 0x4d, 0x27, 0x17, 0x96, 0x74, 0x8c}};
constexpr GUID kIidCompiler = {0x228b4687, 0x5a6a, 0x4730, {0x90, 0x0c, 0x97, 0x02, 0xb2, 0x20, 0x3f, 0x54}};
constexpr GUID kIidUtils = {0x4605c4cb, 0x2019, 0x492a, {0xad, 0xa4, 0x65, 0xf2, 0x0b, 0xb7, 0xd6, 0x7f}};
constexpr GUID kIidResult = {0x58346cda, 0xdde7, 0x4497, {0x94, 0x61, 0x6f, 0x87, 0xaf, 0x5e, 0x06, 0x59}};
constexpr GUID kIidBlob = {0x8ba5fb08, 0x5195, 0x40e2, {0xac, 0x58, 0x0d, 0x98, 0x9c, 0x3a, 0x01, 0x02}};

struct DxcBuffer {
    const void* data;
    SIZE_T size;
    UINT encoding;
};
struct DxcBlob : IUnknown {
    virtual void* STDMETHODCALLTYPE GetBufferPointer() = 0;
    virtual SIZE_T STDMETHODCALLTYPE GetBufferSize() = 0;
};
constexpr UINT kErrors = 2, kDisassembly = 5, kUtf8 = 65001;
struct DxcResult : IUnknown {
    virtual HRESULT STDMETHODCALLTYPE GetStatus(HRESULT*) = 0;
    virtual HRESULT STDMETHODCALLTYPE GetResult(DxcBlob**) = 0;
    virtual HRESULT STDMETHODCALLTYPE GetErrorBuffer(DxcBlob**) = 0;
    virtual BOOL STDMETHODCALLTYPE HasOutput(UINT) = 0;
    virtual HRESULT STDMETHODCALLTYPE GetOutput(UINT, REFIID, void**, IUnknown**) = 0;
};
struct DxcCompiler : IUnknown {
    virtual HRESULT STDMETHODCALLTYPE Compile(const DxcBuffer*, LPCWSTR*, UINT, IUnknown* includes, REFIID,
                                              void**) = 0;
    virtual HRESULT STDMETHODCALLTYPE Disassemble(const DxcBuffer*, REFIID, void**) = 0;
};
struct DxcUtils : IUnknown {
    virtual HRESULT STDMETHODCALLTYPE CreateBlobFromBlob() = 0;
    virtual HRESULT STDMETHODCALLTYPE CreateBlobFromPinned() = 0;
    virtual HRESULT STDMETHODCALLTYPE MoveToBlob() = 0;
    virtual HRESULT STDMETHODCALLTYPE CreateBlob() = 0;
    virtual HRESULT STDMETHODCALLTYPE LoadFile() = 0;
    virtual HRESULT STDMETHODCALLTYPE CreateReadOnlyStreamFromBlob() = 0;
    virtual HRESULT STDMETHODCALLTYPE CreateDefaultIncludeHandler(IUnknown**) = 0;
};
using CreateInstance = HRESULT(__stdcall*)(REFCLSID, REFIID, void**);

struct Job {
    std::string compiler, source, profile, output;
    std::vector<std::string> options; ///< definitions, or what begins with -
};

/// The text of an output, or nothing.
std::string GetText(DxcResult& result, UINT kind) {
    DxcBlob* blob = nullptr;
    if (!result.HasOutput(kind) ||
        FAILED(result.GetOutput(kind, kIidBlob, reinterpret_cast<void**>(&blob), nullptr)) || blob == nullptr)
        return {};
    const std::string text(static_cast<const char*>(blob->GetBufferPointer()), blob->GetBufferSize());
    blob->Release();
    return text.substr(0, text.find('\0'));
}

class Dxc {
public:
    Dxc(const std::string& library, const std::string& includes) : includeDirectory_(Widen(includes)) {
        const HMODULE module = LoadLibraryA(library.c_str());
        const auto create = module == nullptr ? nullptr
                                              : reinterpret_cast<CreateInstance>(reinterpret_cast<void*>(
                                                    GetProcAddress(module, "DxcCreateInstance")));
        if (create != nullptr &&
            SUCCEEDED(create(kClsidUtils, kIidUtils, reinterpret_cast<void**>(&utils_))) &&
            SUCCEEDED(create(kClsidCompiler, kIidCompiler, reinterpret_cast<void**>(&compiler_))))
            utils_->CreateDefaultIncludeHandler(&includes_);
    }

    std::string Compile(const Job& job) {
        if (compiler_ == nullptr)
            return "dxcompiler.dll cannot be loaded";
        std::vector<std::wstring> words = {
            Widen(job.source), L"-T", Widen(job.profile), L"-E",
            L"main",           L"-I", includeDirectory_,  L"-Wno-ignored-attributes"};
        for (const std::string& option : job.options)
            words.push_back(option[0] == '-' ? Widen(option) : L"-D" + Widen(option));
        std::vector<LPCWSTR> arguments;
        for (const std::wstring& word : words)
            arguments.push_back(word.c_str());
        const std::string text = ReadFileText(job.source);
        const DxcBuffer buffer = {text.data(), text.size(), kUtf8};
        DxcResult* result = nullptr;
        HRESULT status = compiler_->Compile(&buffer, arguments.data(), static_cast<UINT>(arguments.size()),
                                            includes_, kIidResult, reinterpret_cast<void**>(&result));
        if (FAILED(status) || FAILED(result->GetStatus(&status)))
            return "IDxcCompiler3::Compile failed";
        DxcBlob* object = nullptr;
        if (FAILED(status) || FAILED(result->GetResult(&object)))
            return GetText(*result, kErrors) + " ";
        const DxcBuffer code = {object->GetBufferPointer(), object->GetBufferSize(), 0};
        if (!WriteFileBytes(job.output, code.data, code.size))
            return job.output + ": cannot be written";
        DxcResult* listing = nullptr;
        if (FAILED(compiler_->Disassemble(&code, kIidResult, reinterpret_cast<void**>(&listing))))
            return "IDxcCompiler3::Disassemble failed";
        const std::string lines = GetText(*listing, kDisassembly);
        WriteFileBytes(job.output + ".txt", lines.data(), lines.size());
        listing->Release();
        object->Release();
        result->Release();
        return {};
    }

private:
    std::wstring includeDirectory_;
    DxcUtils* utils_ = nullptr;
    DxcCompiler* compiler_ = nullptr;
    IUnknown* includes_ = nullptr;
};

// ------------------------------------------------------------------------------------------------ FXC
/// Beside the including file first, then in the include directory: what FXC's own handler does not do.
class Includes final : public ID3DInclude {
public:
    Includes(std::string source, std::string directory)
        : source_(std::move(source)), directory_(std::move(directory)) {}

    HRESULT STDMETHODCALLTYPE Open(D3D_INCLUDE_TYPE, LPCSTR name, LPCVOID parent, LPCVOID* data,
                                   UINT* size) override {
        const auto folder = folders_.find(parent);
        for (const std::string& where : {folder == folders_.end() ? source_ : folder->second, directory_}) {
            const std::string path = where + "/" + name;
            if (GetFileAttributesA(path.c_str()) == INVALID_FILE_ATTRIBUTES)
                continue;
            auto* text = new std::string(ReadFileText(path)); // lives until the program ends, as do the keys
            folders_[text->data()] = GetFolder(path);
            *data = text->data();
            *size = static_cast<UINT>(text->size());
            return S_OK;
        }
        return E_FAIL;
    }
    HRESULT STDMETHODCALLTYPE Close(LPCVOID) override { return S_OK; }

private:
    std::string source_, directory_;
    std::map<LPCVOID, std::string> folders_;
};

class Fxc {
public:
    Fxc(const std::string& library, std::string includes) : includeDirectory_(std::move(includes)) {
        const HMODULE module = LoadLibraryA(library.c_str());
        if (module == nullptr)
            return;
        compile_ =
            reinterpret_cast<pD3DCompile>(reinterpret_cast<void*>(GetProcAddress(module, "D3DCompile")));
        disassemble_ = reinterpret_cast<pD3DDisassemble>(
            reinterpret_cast<void*>(GetProcAddress(module, "D3DDisassemble")));
    }

    std::string Compile(const Job& job) {
        if (compile_ == nullptr || disassemble_ == nullptr)
            return "d3dcompiler_47.dll cannot be loaded";
        std::vector<std::string> words;
        for (const std::string& option : job.options) {
            const std::size_t equal = option.find('=');
            words.push_back(option.substr(0, equal));
            words.push_back(option.substr(equal + 1));
        }
        std::vector<D3D_SHADER_MACRO> macros;
        for (std::size_t i = 0; i < words.size(); i += 2)
            macros.push_back({words[i].c_str(), words[i + 1].c_str()});
        macros.push_back({nullptr, nullptr});
        const std::string text = ReadFileText(job.source);
        Includes includes(GetFolder(job.source), includeDirectory_);
        ID3DBlob *code = nullptr, *errors = nullptr, *listing = nullptr;
        if (FAILED(compile_(text.data(), text.size(), job.source.c_str(), macros.data(), &includes, "main",
                            job.profile.c_str(), 0, 0, &code, &errors)))
            return errors == nullptr ? "D3DCompile failed"
                                     : static_cast<const char*>(errors->GetBufferPointer());
        if (FAILED(disassemble_(code->GetBufferPointer(), code->GetBufferSize(), 0, nullptr, &listing)))
            return "D3DDisassemble failed";
        const bool written = WriteFileBytes(job.output, code->GetBufferPointer(), code->GetBufferSize()) &&
                             WriteFileBytes(job.output + ".txt", listing->GetBufferPointer(),
                                            listing->GetBufferSize() - 1); // its end is a zero
        return written ? "" : job.output + ": cannot be written";
    }

private:
    std::string includeDirectory_;
    pD3DCompile compile_ = nullptr;
    pD3DDisassemble disassemble_ = nullptr;
};

/// The first line that says "error", or the first.
std::string GetFirstError(const std::string& messages) {
    std::size_t at = messages.find("error");
    at = at == std::string::npos ? 0 : messages.rfind('\n', at) + 1;
    std::string line = messages.substr(at, messages.find('\n', at) - at);
    for (char& c : line)
        c = c == '\t' || c == '\r' ? ' ' : c;
    return line;
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::cerr << "HlslWindows dxcompiler.dll d3dcompiler_47.dll INCLUDE_DIR <jobs\n";
        return 2;
    }
    Dxc dxc(argv[1], argv[3]);
    Fxc fxc(argv[2], argv[3]);
    std::string line;
    while (std::getline(std::cin, line)) {
        if (line.ends_with('\r'))
            line.pop_back();
        std::istringstream fields(line);
        Job job;
        std::getline(fields, job.compiler, '\t');
        std::getline(fields, job.source, '\t');
        std::getline(fields, job.profile, '\t');
        std::getline(fields, job.output, '\t');
        for (std::string option; std::getline(fields, option, '\t');)
            job.options.push_back(option);
        const std::string error = job.compiler == "dxc" ? dxc.Compile(job) : fxc.Compile(job);
        std::cout << (error.empty() ? "ok" : "error\t" + GetFirstError(error)) << std::endl;
    }
    return 0;
}
