// A source of a project that has Palpate below it, and does not use it here.

static_assert(__cplusplus == 201703L, "the project says C++17");

int bystander() {
  return 17;
}
