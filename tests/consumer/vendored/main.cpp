// SPDX-License-Identifier: MIT
int GetWidth(const char* path);

int main(int, char** argv) {
    return GetWidth(argv[1]) == 24 ? 0 : 1; // the format specification's V1
}
