// SPDX-License-Identifier: MIT
// Loaded before the others: libraries stay where they are. LeakSanitizer looks when a program ends, and has no module's name for what
// was allocated by one that is gone by then, as a Vulkan driver is; the list of leaks that are not ours goes by names.
extern "C" int dlclose(void* /*library*/) {
    return 0;
}
