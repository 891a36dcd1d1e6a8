// A source that does not use Palpate, in a project that contains Palpate as a subproject.

static_assert(__cplusplus == 201703L, "the project sets C++17");

int bystander() {
  return 17;
}
