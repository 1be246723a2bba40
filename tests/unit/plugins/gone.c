/* SPDX-License-Identifier: Apache-2.0 */
/* A library that a plugin is linked with, in a folder where the loader does not look. */
int patina_gone(void);
__attribute__((visibility("default"))) int patina_gone(void) { return 1; }
