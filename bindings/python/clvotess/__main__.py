from clvotess import main

main()
