#!/usr/bin/python3
"""No call of MPI, PETSc, METIS or HDF5 stands where its return code is dropped: each is an argument of a check, or its result is
used. And no reduction of doubles depends on the order of what is not a number."""
import os
import pathlib
import re
import unittest

SOURCE = pathlib.Path(os.environ.get("UNIBODY_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
FOLDERS = ("src", "partition")

CALL = re.compile(r"\b(MPI_[A-Z]\w*|METIS_[A-Z]\w*|H5[A-Z]+[a-z]\w*|(?:Petsc|Vec|Mat|SNES|KSP|PC|IS)[A-Z]\w*)\s*\(")
# What returns no code: times, the end of the program, and names of types and of this program that look alike.
NO_CODE = re.compile(r"^(MPI_Wtime|MPI_Abort|PetscSession|Vec3\w*|Vec4\w*|MatrixBase)$")


# Of these the result may differ between ranks; src/core/largest.hpp says why.
LARGEST = re.compile(r"\bMPI_DOUBLE\s*,\s*MPI_(?:MAX|MIN)\b")


def without_comments_and_strings(text):
    text = re.sub(r'"(?:\\.|[^"\\\n])*"', '""', text)
    return re.sub(r"//[^\n]*", lambda m: " " * len(m.group()), text)


def dropped_codes(text):
    """The calls whose result nobody looks at, with their lines."""
    text = without_comments_and_strings(text)
    found = []
    for match in CALL.finditer(text):
        if NO_CODE.match(match.group(1)):
            continue
        head = text[:match.start()].rstrip()
        if re.search(r"\b(?:namespace|class|struct|explicit|operator)$|~$", head):
            continue  # a declaration
        before = re.split(r"[;{}]", head)[-1].strip()  # of the same statement
        is_alone = head.endswith((";", "{", "}")) and not re.search(r"\w\s*\{$", head)
        behind_condition = re.fullmatch(r"(?:else|(?:else )?(?:if|for|while)\s*\(.*\))", before, re.S)
        behind_comma = re.fullmatch(r"\w+\(.*\),", before, re.S) and before.count("(") == before.count(")")
        dropped = is_alone or before == "" and not head.endswith("{") or behind_condition or behind_comma
        if dropped:
            found.append((text.count("\n", 0, match.start()) + 1, match.group(1)))
    return found


class ReturnCodes(unittest.TestCase):
    def test_every_code_is_looked_at(self):
        calls = 0
        for folder in FOLDERS:
            for path in sorted((SOURCE / folder).rglob("*.[ch]pp")):
                text = path.read_text()
                calls += len(CALL.findall(without_comments_and_strings(text)))
                for line, name in dropped_codes(text):
                    self.fail(f"{path.relative_to(SOURCE)}:{line}: nobody looks at what {name} returns")
        self.assertGreater(calls, 200, "the calls are not found: this test looks for the wrong thing")

    def test_largest_doubles_are_the_same_on_every_rank(self):
        found = [path.relative_to(SOURCE).as_posix() for folder in FOLDERS for path in sorted((SOURCE / folder).rglob("*.[ch]pp"))
                 if LARGEST.search(without_comments_and_strings(path.read_text()))]
        self.assertEqual(found, ["src/core/largest.cpp"])

    def test_what_would_be_found(self):
        for text in ("{\n  MPI_Barrier(comm);\n}", "if (v) VecDestroy(&v);", "x = 1;\n  H5Tclose(type);", "for (Vec v : all) VecDestroy(&v);",
                     "check_mpi(MPI_Send(a)), MPI_Recv(b);", "if (a)\n  b();\nelse\n  METIS_NodeND(c);"):
            self.assertEqual(len(dropped_codes(text)), 1, text)
        for text in ("{\n  check_mpi(MPI_Barrier(comm));\n}", "const int status = METIS_NodeND(a);", "if (H5Fflush(f) < 0) x();",
                     "check_mpi(MPI_A(x)), check_mpi(MPI_B(y));", "Handle file(H5Fopen(a), H5Fclose, b);", "return MPI_Wtime();"):
            self.assertEqual(dropped_codes(text), [], text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
